"""Random vehicles in motion: fewest active intervals, least times, here and with CasADi and IPOPT.

    python -m benchmarks.random_vehicles [--cases 100] [--seed 0] [--starts 16] [--json FILE]

Half of the cases are slews in a given time (hands-off here; least effort by IPOPT, whose answers
are then cut off at a threshold), half are turns in free time.  Both sides have the same number of
starts, of intervals and of Runge-Kutta steps, and are judged by the same flights under error
control (SciPy's DOP853).  Times are of the processor.  Every case is written as soon as it has
ended; a file of the same seed and number of starts is continued.
"""

from __future__ import annotations

import argparse
import functools
import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.__main__ import machine  # noqa: E402
from benchmarks.casadi_moving import Ended, Shape, Solver  # noqa: E402
from benchmarks.inertial_manoeuvre import InertialManoeuvre, of_slew, of_turn  # noqa: E402
from benchmarks.informed_starts import informed_starts  # noqa: E402
from benchmarks.random_manoeuvres import (  # noqa: E402
    INTERVALS,
    KINDS,
    SUBSTEPS,
    WHEELS,
    Case,
    draw,
)
from jaxatt.problems.hands_off.build import build_slew  # noqa: E402
from jaxatt.problems.time_optimal.phase import build_time_task  # noqa: E402
from jaxatt.problems.time_optimal.search import search_free_time  # noqa: E402
from jaxatt.runtime.arrays import Floats  # noqa: E402

SHAPES = {
    "slew": Shape(INTERVALS["slew"], SUBSTEPS, 3, WHEELS - 3, free_time=False),
    "turn": Shape(INTERVALS["turn"], SUBSTEPS, WHEELS, 0, free_time=True),
}
THRESHOLDS = (0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4)
"""Shares of the limits at which an answer of least effort is cut off: the largest that reaches."""
SIDES = ("jaxatt", "ipopt")
KEYS = {"slew": "active", "turn": "final_time"}
"""What is compared."""
_ACTIVE = 1e-9
_EXCESS = 1e-7
_SAME = 1e-4
_FINE = 16


@dataclass(frozen=True)
class Side:
    """How a side ended.

    reached : whether the best answer does.  active : its intervals.  final_time : [s].
    good : starts that reached.  cpu_s : [s] of all starts.
    """

    reached: bool
    active: int
    final_time: float
    good: int
    cpu_s: float


def reaches(case: Case, m: InertialManoeuvre, u: Floats, step: float) -> bool:
    """Whether controls (N, b) end within the tolerances and keep the limits."""
    target = case.scenario.targets[0]
    if max(np.abs(u).max(), np.abs(u @ m.others.T).max(initial=0.0)) > 1.0 + _EXCESS:
        return False
    angle, rate = m.flown_errors(u, step)
    return angle <= target.attitude_tolerance and rate <= target.rate_tolerance


def nearly(case: Case, m: InertialManoeuvre, u: Floats, step: Floats) -> Floats:
    """(S,), whether controls (S, N, b) seem to reach, by fine steps of fixed length."""
    target = case.scenario.targets[0]
    x = np.tile(np.concatenate([m.start, m.start_rate]), (len(u), 1))
    for k in range(u.shape[1]):
        x = m.after(x, u[:, k], np.reshape(step, (-1, 1)), _FINE)
    angle, rate = m.errors(x)
    return (angle <= target.attitude_tolerance) & (rate <= target.rate_tolerance)


def count(u: Floats) -> int:
    """Active intervals of controls (N, b)."""
    return int((np.abs(u).max(axis=1) > _ACTIVE).sum())


def thresholded(case: Case, m: InertialManoeuvre, ended: list[Ended]) -> list[tuple[int, Floats]]:
    """Active intervals and controls of answers that seem to reach, cut as far as they can be."""
    shares, u = np.array([*THRESHOLDS, 0.0]), np.stack([one.u for one in ended])
    size = np.abs(u).max(axis=2, keepdims=True)
    cut = np.where(size[:, None] > shares[:, None, None], u[:, None], 0.0)
    flat = cut.reshape(-1, *u.shape[1:])
    good = nearly(case, m, flat, np.full(len(flat), ended[0].step)).reshape(len(u), -1)
    found = [cut[i, np.argmax(good[i])] for i in np.flatnonzero(good.any(axis=1))]
    return sorted(((count(each), each) for each in found), key=lambda pair: pair[0])


def other_side(case: Case, m: InertialManoeuvre, solver: Solver, starts: int, seed: int) -> Side:
    """IPOPT from informed starts."""
    shape, began = solver.shape, time.process_time()
    drawn = informed_starts(m, shape.intervals, case.horizon, starts, seed)
    ended = [solver(m, start) for start in drawn]
    cpu = time.process_time() - began
    # What left the limits by rounding is put back on them.
    ended = [replace(one, u=np.clip(one.u, -1.0, 1.0)) for one in ended]
    if shape.free_time:
        u, step = np.stack([one.u for one in ended]), np.array([one.step for one in ended])
        good = np.flatnonzero(nearly(case, m, u, step))
        pairs = [(float(step[i]), u[i]) for i in good[np.argsort(step[good])]]
    else:
        pairs = [(case.horizon / shape.intervals, u) for _, u in thresholded(case, m, ended)]
    for step_s, controls in pairs:
        if reaches(case, m, controls, step_s):
            final = step_s * shape.intervals
            return Side(True, count(controls), final, len(pairs), cpu)
    return Side(False, shape.intervals, np.inf, 0, cpu)


def this_side(case: Case, m: InertialManoeuvre, starts: int) -> Side:
    """The package."""
    began = time.process_time()
    if case.horizon is None:
        task = build_time_task(case.scenario)
        found = search_free_time(task, starts, 0)
        u, step, good = found.scaled[found.best], found.step[found.best], found.reached.sum()
    else:
        phase = jaxatt.solve(case.scenario, starts=starts, seed=0).phases[0]
        u, step = phase.controls @ np.linalg.inv(m.to_body).T, phase.step
        good = phase.starts.reached.sum()
    cpu = time.process_time() - began
    ok = reaches(case, m, u, float(step))
    return Side(ok, count(u), float(step) * len(u) if ok else np.inf, int(good), cpu)


def compare(
    row: dict[str, Any], sides: list[str], solver: Callable[[], Solver], starts: int, seed: int
) -> None:
    """Run sides on the case of a row, and enter into it what they found."""
    case = draw(row["kind"], row["index"], seed)
    row |= {name: value for name, value in vars(case).items() if name != "scenario"}
    if case.horizon is None:
        m = of_turn(build_time_task(case.scenario))
    else:
        m = of_slew(build_slew(case.scenario))
    for side in sides:
        ours = side == "jaxatt"
        found = this_side(case, m, starts) if ours else other_side(case, m, solver(), starts, seed)
        row[side] = asdict(found)


def line(row: dict[str, Any]) -> str:
    """One case in words."""
    key = KEYS[row["kind"]]
    told = (
        f"{row['kind']} {row['index']:3}  {row['mass']:6.1f} kg  {row['rate']:4.1f} to "
        f"{row['end_rate']:4.1f} deg/s  stored {row['stored']:.2f}"
    )
    for side in SIDES:
        if side in row:
            found = f"{row[side][key]:8.5g}" if row[side]["reached"] else "  missed"
            told += f"   {side} {found} ({row[side]['good']:2} good, {row[side]['cpu_s']:5.1f} s)"
    return told


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """What the cases show, kind by kind; of counts and times where both sides reached."""
    found: dict[str, Any] = {}
    for kind, key in KEYS.items():
        own = [row for row in rows if row["kind"] == kind and all(side in row for side in SIDES)]
        both = [row for row in own if row["jaxatt"]["reached"] and row["ipopt"]["reached"]]
        told: dict[str, Any] = {"cases": len(own)}
        for side in SIDES:
            told[side] = {
                "reached": sum(row[side]["reached"] for row in own),
                "good_starts": sum(row[side]["good"] for row in own),
                "mean": float(np.mean([row[side][key] for row in both] or [np.nan])),
                "median_cpu_s": float(np.median([row[side]["cpu_s"] for row in own] or [0.0])),
            }
        ratio = {row["index"]: row["jaxatt"][key] / row["ipopt"][key] for row in both}
        told["missed_here"] = [r["index"] for r in own if r not in both and r["ipopt"]["reached"]]
        told["missed_there"] = [r["index"] for r in own if r not in both and r["jaxatt"]["reached"]]
        told["less_here"] = sum(r < 1.0 - _SAME for r in ratio.values())
        told["more_here"] = [index for index, r in ratio.items() if r > 1.0 + _SAME]
        told["largest_ratio"] = max(ratio.values(), default=None)
        found[kind] = told
    return found


def main() -> None:
    """Run the cases that are not in the file yet, and print what all of them show."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100, help="half of them slews, half turns")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--starts", type=int, default=16)
    parser.add_argument("--json", type=Path, help="written after every case, and continued")
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    parser.add_argument("--side", choices=SIDES, nargs="+", default=list(SIDES))
    parser.add_argument("--kind", choices=KINDS, nargs="+", default=list(KINDS))
    parser.add_argument("--again", action="store_true", help="run sides that the file has, too")
    options = parser.parse_args()
    settings = {"seed": options.seed, "starts": options.starts}
    rows: list[dict[str, Any]] = []
    if options.json is not None and options.json.exists():
        kept = json.loads(options.json.read_text(encoding="utf-8"))
        if kept["settings"] != settings:
            parser.error(f"{options.json} has {kept['settings']}: choose another file")
        rows = kept["cases"]
    known = {(row["kind"], row["index"]): row for row in rows}
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        solvers = functools.cache(lambda kind: Solver(SHAPES[kind], folder))
        for number in range(options.cases):
            kind, index = KINDS[number % 2], number // 2
            row = known.get((kind, index), {"kind": kind, "index": index})
            sides = [side for side in options.side if options.again or side not in row]
            if not sides or kind not in options.kind:
                continue
            compare(row, sides, functools.partial(solvers, kind), options.starts, options.seed)
            if (kind, index) not in known:
                rows.append(row)
            print(line(row), flush=True)
            if options.json is not None:
                whole = {"machine": machine(), "settings": settings, "cases": rows}
                whole["summary"] = summary(rows)
                options.json.write_text(json.dumps(whole, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(summary(rows), indent=2))


if __name__ == "__main__":
    main()
