"""Where a step of the search spends its time: one chunk of starts on one core.

    python -m benchmarks.step_profile [--rows 64]

Least of many interleaved runs: a roll-out as the answer's, one pass that gives the linearised end,
and a whole search divided by its steps.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import jaxatt

jaxatt.configure()

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402

from benchmarks.cases import task_of  # noqa: E402
from jaxatt.multistart.driver import run_starts  # noqa: E402
from jaxatt.optimize.reweighting.condensed import CondensedReweighting  # noqa: E402
from jaxatt.optimize.reweighting.weights import Reweighting  # noqa: E402
from jaxatt.problems.hands_off.search.batch import Form, broadcast_lanes  # noqa: E402
from jaxatt.problems.hands_off.search.polish import count_arguments  # noqa: E402
from jaxatt.problems.hands_off.search.starts import draw  # noqa: E402
from jaxatt.problems.hands_off.slew.model import SlewForm, fly_nodes  # noqa: E402
from jaxatt.problems.hands_off.slew.pulse_equations import pulse_equations  # noqa: E402


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=100)
    options = parser.parse_args()
    task, rows, form = task_of("hypso1-90-45-15"), options.rows, SlewForm()
    starts = draw(0, rows, task.intervals, task.size, task.long_way_probability())
    a = task.arguments
    lanes = broadcast_lanes(starts.u, a.free, a.row_weight, starts.sign)
    last, plant, steps = jnp.moveaxis(jnp.asarray(starts.u), 0, -1), a.plant, Reweighting()

    def end(u: jax.Array) -> Any:
        return fly_nodes(u, plant, form)[0]

    def linearised(u: jax.Array) -> Any:
        found = pulse_equations(u, u**2, u, jnp.asarray(False), plant, form)
        return found.rows, found.matrix, found.pullback(found.reached)

    flown, swept = (jax.jit(jax.vmap(part, in_axes=-1, out_axes=-1)) for part in (end, linearised))
    chosen, arguments = Form(task.system, task.shared, "roots", task.size), count_arguments(task)
    solver = CondensedReweighting(steps)
    parts = {
        "roll-out": lambda: flown(last),
        "one pass, linearised": lambda: swept(last),
        "search": lambda: run_starts(solver, chosen, lanes, arguments, rows=rows),
    }
    least = dict.fromkeys(parts, float("inf"))
    for repeat in range(options.repeats + 1):
        for name, part in parts.items():
            began = time.perf_counter()
            jax.block_until_ready(part())
            if repeat:
                least[name] = min(least[name], time.perf_counter() - began)
    count = steps.deciding + steps.settling
    for name, seconds in least.items():
        print(f"{name}: {1e3 * seconds:.2f} ms for {rows} starts")
    print(f"a step of the search: {1e3 * least['search'] / count:.2f} ms, {count} steps")


if __name__ == "__main__":
    main()
