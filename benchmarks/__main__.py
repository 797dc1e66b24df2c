"""Speed of the package beside what its users run today, in one run on the same cores.

    python -m benchmarks [--starts 64] [--repeats 15] [--quick] [--json FILE] [--table FILE]

Both sides get all cores: the package one chunk of starts a core, CasADi one process a core.
Compilation and building stand apart, a first run warms up, medians are printed.  On a machine with
an accelerator the package's side runs there, and the table says so.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import jaxatt

jaxatt.configure()

import jax  # noqa: E402

from benchmarks import jaxatt_side, tables  # noqa: E402
from benchmarks.both_cores import run_together  # noqa: E402
from benchmarks.cases import BEST_KNOWN, task_of  # noqa: E402
from benchmarks.peak import fused_peak  # noqa: E402
from benchmarks.processes import cold_and_warm  # noqa: E402
from benchmarks.usefulness import useful  # noqa: E402

MAIN = "hypso1-90-45-15"
_LARGE_BATCH = 4096
"""Of roll-outs, which take too little time to be measured in small ones."""
_TURNS = 5
"""Of both sides, for the ratios that a machine's faster and slower minutes would spoil."""
SLEWS = (MAIN, "hypso1-75-50-15", "hypso1-90-45-15-half-torque")


def machine() -> dict[str, Any]:
    """What the figures were taken on."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        lines = information.read_text().splitlines()
        model = next((x.split(":", 1)[1].strip() for x in lines if "model name" in x), model)
    return {
        "date": datetime.date.today().isoformat(),
        "processor": model,
        "cores": len(os.sched_getaffinity(0)),
        "device": jax.devices()[0].device_kind,
        "python": platform.python_version(),
        "jax": jax.__version__,
        "jaxatt": jaxatt.pipeline.solve.versions()["jaxatt"],
    }


def casadi_side(case: str, method: str, starts: int, folder: Path) -> dict[str, Any]:
    """One method of the other side on all cores."""
    together = run_together(case, starts, 0, method, folder=folder / method / case)
    task = task_of(case)
    good = sum(int(useful(task, o.controls, BEST_KNOWN[case]).sum()) for o in together.outcomes)
    cpu = sorted(seconds for outcome in together.outcomes for seconds in outcome.cpu_s)
    return {
        "case": case,
        "method": method,
        "starts": len(cpu),
        "build_s": together.build_s,
        "run_s": together.wall_s,
        "cpu_ms_a_start": 1e3 * float(cpu[len(cpu) // 2]),
        "useful": good,
        "useful_per_second": good / together.wall_s,
        "memory_MiB": max(outcome.memory_MiB for outcome in together.outcomes),
    }


def in_turn(options: argparse.Namespace, batches: tuple[int, ...], folder: Path) -> dict[str, Any]:
    """Useful starts a second of both sides, one straight after the other."""
    rates = {}
    for batch in batches:
        found = jaxatt_side.searches(MAIN, batch, options.repeats)
        rates[str(batch)] = found.per_second * (found.useful_share or 0.0)
    other = casadi_side(MAIN, "ipopt", options.starts, folder)["useful_per_second"]
    print(f"in turn: {rates} and, IPOPT, {other:.1f} useful a second", flush=True)
    return {"jaxatt": rates, "ipopt": other}


def main() -> None:
    """Measure everything and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--starts", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--quick", action="store_true", help="one slew, no chain, no processes")
    parser.add_argument("--json", type=Path, help="write all figures there")
    parser.add_argument("--table", type=Path, help="write the tables there, as Markdown")
    options = parser.parse_args()
    report: dict[str, Any] = {"machine": machine(), "peak_flops": fused_peak()}
    batches = (64,) if options.quick else (64, 256, 1024)
    slews = SLEWS[:1] if options.quick else SLEWS
    cases = slews if options.quick else (*slews, "double-integrator")
    rows: list[jaxatt_side.Throughput] = []
    for batch in batches:
        rows += jaxatt_side.rollouts(batch, options.repeats)
        rows.append(jaxatt_side.searches(MAIN, batch, options.repeats))
        _tell(rows[-3:])
    if not options.quick:
        rows += jaxatt_side.rollouts(_LARGE_BATCH, options.repeats)
        _tell(rows[-2:])
    for case in slews[1:]:
        rows.append(jaxatt_side.searches(case, options.starts, options.repeats))
        _tell(rows[-1:])
    for case in (cases[0], cases[-1]):
        rows.append(jaxatt_side.searches(case, options.starts, options.repeats, polished=True))
        _tell(rows[-1:])
    rows.append(jaxatt_side.searches(MAIN, options.starts, max(3, options.repeats // 4), "riccati"))
    _tell(rows[-1:])
    report["jaxatt"] = [asdict(row) for row in rows]
    report["certificate"] = jaxatt_side.certificates(MAIN, max(3, options.repeats // 3))
    report["casadi"] = []
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            methods = ["ipopt"] if case == "double-integrator" else ["ipopt", "fatrop"]
            for method in methods:
                side = casadi_side(case, method, options.starts, Path(folder))
                report["casadi"].append(side)
                print(
                    f"{case}, {method}: {side['useful_per_second']:.1f} useful a second", flush=True
                )
        if not options.quick:
            for method in ("thesis-chain", "thesis-chain-warm"):
                report["casadi"].append(casadi_side(MAIN, method, 2, Path(folder)))
    if not options.quick:
        with tempfile.TemporaryDirectory() as folder:
            report["turns"] = [in_turn(options, batches, Path(folder)) for _ in range(_TURNS)]
        report["processes"] = {k: asdict(v) for k, v in cold_and_warm(MAIN).items()}
    text = tables.markdown(report)
    print(text)
    if options.table is not None:
        options.table.write_text(text + "\n")
    if options.json is not None:
        options.json.write_text(json.dumps(report, indent=2) + "\n")


def _tell(rows: list[jaxatt_side.Throughput]) -> None:
    for row in rows:
        print(f"{row.what}, {row.batch}: {row.per_second:.0f} a second", flush=True)


if __name__ == "__main__":
    main()
