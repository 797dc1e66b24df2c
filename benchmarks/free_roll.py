"""A free roll beside the best of many fixed rolls, with as many starts for each of them.

    python -m benchmarks.free_roll [--cases sparse time energy thrusters] [--rolls 72] [--starts 16]

Every case is solved once to compile, then timed, with the roll free and with rolls spread evenly
over a turn, from that of the shortest turn on.  Times are CPU seconds of the process, so that other
work on the machine does not count; a fixed roll's is the median of all of them.
"""

from __future__ import annotations

import argparse
import copy
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from jaxatt import scenarios  # noqa: E402
from jaxatt.attitude.host_turns import product, turned_by  # noqa: E402
from jaxatt.problems.scenario import Scenario  # noqa: E402
from jaxatt.records.phase import Phase  # noqa: E402
from jaxatt.report.free_roll import free_roll  # noqa: E402

SAME = 1e-5
"""Relative difference of objectives that counts as none."""


class Case(NamedTuple):
    """A bundled scenario with changes, and a body axis to point where its own target has it.

    axis : None where the scenario leaves the roll free itself.  unit : of the objective.
    """

    name: str
    changes: dict[str, Any]
    axis: tuple[float, float, float] | None
    unit: str
    objective: Callable[[Phase], tuple[float, ...]]


def _sparse(phase: Phase) -> tuple[float, ...]:
    return (float(phase.active_intervals), phase.l1_effort)


def _time(phase: Phase) -> tuple[float, ...]:
    return (phase.final_time,)


def _energy(phase: Phase) -> tuple[float, ...]:
    return (phase.total_cost,)


FASTEST = {
    "objective.kind": "minimum-time",
    "transcription.attitude": "quaternion",
    "horizon.intervals": 30,
}
COARSE = {"horizon.intervals": 30, "horizon.coast_intervals": 0}
CASES = {
    "sparse": Case("hypso1-sun-free-roll", {}, None, "intervals, N m s", _sparse),
    "time": Case("mrp-k3-rk4", FASTEST, (0.0, 0.0, 1.0), "s", _time),
    "energy": Case("hypso1-netpower", {}, (0.0, 0.0, 1.0), "J spent", _energy),
    "thrusters": Case("eseo-1", COARSE, (0.0, 0.0, 1.0), "intervals, N m s", _sparse),
}


class Outcome(NamedTuple):
    """Objective, infinite where the target is not reached, roll [deg], CPU time [s] of a solve."""

    objective: tuple[float, ...]
    roll: float
    time: float

    @property
    def text(self) -> str:
        """The objective in words."""
        return ", ".join(f"{value:.6g}" for value in self.objective)


def freed(case: Case, starts: int) -> Scenario:
    """The scenario of a case, with the roll of its target free."""
    changes = {**case.changes, "solver.starts": starts}
    scenario = scenarios.replace(scenarios.load(case.name), changes)
    if case.axis is None:
        return scenario
    document = copy.deepcopy(dict(scenario.document))
    kept = ("attitude_tolerance_deg", "rate_tolerance_rad_s")
    target = {key: value for key, value in document["target"].items() if key in kept}
    q = np.asarray(scenario.targets[0].q_ob)
    direction = product(product(q, np.array([0.0, *case.axis])), q * [1.0, -1.0, -1.0, -1.0])[1:]
    axes = "direction_orbit" if scenario.family == "hands-off" else "direction_inertial"
    if scenario.orbit is None:
        axes = "direction_inertial"
    target["align"] = {"body": list(case.axis), axes: direction.tolist()}
    document["target"] = target
    document.pop("printed", None)
    return scenarios.from_mapping(document)


def solved(case: Case, scenario: Scenario, roll: float | None = None) -> Outcome:
    """Solve a scenario; roll : [deg], where it is fixed."""
    begun = time.process_time()
    result = jaxatt.solve(scenario)
    spent = time.process_time() - begun
    phase = result.phases[0]
    found = free_roll(phase)
    turned = roll if found is None else found["roll_deg"]
    value = case.objective(phase) if phase.reached else (np.inf,)
    return Outcome(value, float(turned or 0.0), spent)


def fixed(scenario: Scenario, roll: float) -> Scenario:
    """The same with the roll fixed, [deg] from that of the shortest turn."""
    target = scenario.targets[0]
    assert target.boresight is not None
    near = target.facing(scenario.initial.q_ob)
    turn = turned_by(np.deg2rad(roll) * target.boresight)
    whole = replace(near.facing(product(near.q_ob, turn)), boresight=None)
    return replace(scenario, targets=(whole,))


def compare(case: Case, starts: int, rolls: int) -> tuple[Outcome, Outcome, list[Outcome]]:
    """The free roll, the best fixed one, and all fixed ones."""
    scenario = freed(case, starts)
    degrees = [360.0 * k / rolls for k in range(rolls)]
    solved(case, scenario)
    solved(case, fixed(scenario, 0.0), 0.0)
    free = solved(case, scenario)
    others = [solved(case, fixed(scenario, roll), roll) for roll in degrees]
    return free, min(others, key=lambda other: other.objective), others


def main() -> None:
    """Print a row for every case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", nargs="*", default=list(CASES), choices=list(CASES))
    parser.add_argument("--rolls", type=int, default=72)
    parser.add_argument("--starts", type=int, default=16)
    options = parser.parse_args()
    head = ("case", "objective", "free", "roll [deg]", "best fixed", "its roll", "worst fixed")
    head = (*head, "free [CPU s]", "one fixed [CPU s]", "ratio", "no worse")
    print("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    for name in options.cases:
        case = CASES[name]
        free, best, others = compare(case, options.starts, options.rolls)
        one = statistics.median(other.time for other in others)
        worst = max(others, key=lambda other: other.objective)
        last = best.objective[-1]
        allowed = (*best.objective[:-1], last + SAME * abs(last))
        cells = (
            f"{case.name}, {name}",
            case.unit,
            free.text,
            f"{free.roll:.2f}",
            best.text,
            f"{best.roll:.0f}",
            worst.text,
            f"{free.time:.2f}",
            f"{one:.2f}",
            f"{free.time / one:.2f}",
            "yes" if free.objective <= allowed else "NO",
        )
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
