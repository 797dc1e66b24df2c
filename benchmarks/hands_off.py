"""Speed of the hands-off search: roll-outs, derivatives and starts per second, by batch size.

    python benchmarks/hands_off.py [--batches 64 256] [--repeats 5] [--json FILE]

Compile time stands apart from run time, one warm-up run is not counted, medians are printed.
A start is *useful* when its flight with fine steps is within 0.1 deg, 1e-4 rad/s and the torque
limit, and it has the best-known number of active intervals.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

from jaxatt import scenarios  # noqa: E402
from jaxatt.multistart.batch import Form, broadcast_lanes, solve_lanes  # noqa: E402
from jaxatt.multistart.polish import (  # noqa: E402
    HOMOTOPY,
    POLISH,
    count_arguments,
    effort_arguments,
)
from jaxatt.multistart.starts import draw  # noqa: E402
from jaxatt.scenarios.build import build_task  # noqa: E402

SCENARIO, BEST_KNOWN = "hypso1-90-45-15", 2


@dataclass(frozen=True)
class Row:
    """One measurement: seconds are medians of whole batches."""

    what: str
    batch: int
    compile_s: float
    run_s: float
    per_second: float
    useful_share: float | None = None


def timed(run: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Seconds of the first call less a later one, and the median of the later ones."""

    def once() -> float:
        began = time.perf_counter()
        jax.block_until_ready(run())
        return time.perf_counter() - began

    first = once()
    once()
    median = statistics.median(once() for _ in range(repeats))
    return max(0.0, first - median), median


def measure(batch: int, repeats: int) -> list[Row]:
    """All measurements at one batch size."""
    task = build_task(scenarios.load(SCENARIO))
    starts = draw(0, batch, task.intervals, task.size, task.long_way_probability())
    u = jnp.asarray(starts.u)
    plant = task.arguments.plant

    def rows(one):
        return task.system.rows(one, plant)

    forward = jax.jit(jax.vmap(rows))
    jacobian = jax.jit(jax.vmap(jax.jacrev(rows)))
    form = Form(task.system, task.shared)
    free, weight = task.arguments.free, task.arguments.row_weight

    def decide():
        lanes = broadcast_lanes(starts.u, free, weight, starts.sign)
        return solve_lanes(form, lanes, count_arguments(task), HOMOTOPY, rows=batch)

    began = time.perf_counter()
    decided = np.nan_to_num(decide().x)
    first = time.perf_counter() - began
    support = np.abs(decided).max(axis=-1, keepdims=True) > 1e-3
    masks = np.broadcast_to(support, decided.shape) * np.asarray(free)

    def polish():
        lanes = broadcast_lanes(decided * masks, masks, weight, starts.sign)
        return solve_lanes(form, lanes, effort_arguments(task), POLISH, rows=batch)

    controls = task.to_controls(np.nan_to_num(polish().x))
    verdict, _ = task.verify(controls)
    active = (np.abs(controls) > 0.0).any(axis=2).sum(axis=1)
    useful = (
        (verdict.errors["attitude"] < np.deg2rad(0.1))
        & (verdict.errors["rate"] < 1e-4)
        & (verdict.limit_violation <= 1e-9)
        & (active == BEST_KNOWN)
    ).mean()

    found = []
    for what, run in (
        ("roll-outs", lambda: forward(u)),
        ("terminal Jacobians", lambda: jacobian(u)),
    ):
        compiling, running = timed(run, repeats)
        found.append(Row(what, batch, compiling, running, batch / running))
    _, deciding = timed(decide, repeats)
    _, polishing = timed(polish, repeats)
    total = deciding + polishing
    compiling = max(0.0, first - deciding)
    found.append(
        Row("starts, decided and polished", batch, compiling, total, batch / total, useful)
    )
    return found


def main() -> None:
    """Measure and print a table; write JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--batches", type=int, nargs="+", default=[64, 256])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    machine = {
        "device": jax.devices()[0].device_kind,
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "jax": jax.__version__,
        "date": datetime.date.today().isoformat(),
        "scenario": SCENARIO,
    }
    print(machine)
    print("| what | batch | compile [s] | run [s] | per second | useful |")
    print("| --- | --- | --- | --- | --- | --- |")
    rows = []
    for batch in options.batches:
        for row in measure(batch, options.repeats):
            rows.append(row)
            share = "" if row.useful_share is None else f"{100 * row.useful_share:.0f} %"
            print(
                f"| {row.what} | {row.batch} | {row.compile_s:.1f} | {row.run_s:.4f} "
                f"| {row.per_second:.0f} | {share} |",
                flush=True,
            )
    if options.json is not None:
        options.json.write_text(json.dumps({"machine": machine, "rows": [asdict(r) for r in rows]}))


if __name__ == "__main__":
    main()
