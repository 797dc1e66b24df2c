"""Turns in free time to many targets: the starts of all of them are one batch."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.interior_point.solver import InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.starts import starts_of
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight_error import fly_all_until_agreed

_TRIES = 3
"""Answers of a target that are flown, the best by the solver's count first, until one reaches."""


def answer_targets(
    task: ReorientationTask, targets: Floats, starts: int, seed: int
) -> TargetAnswers:
    """Answer a turn for many targets q_ob (M, 4), in place of its own.

    starts : of every target, drawn as for that target alone.
    """
    count = len(targets)
    paths = drawn_starts(task, targets, starts, seed)
    solution = solve_paths(task, paths)
    found = _Flown(task, targets, solution, starts)
    rows = np.arange(count)
    for attempt in range(min(_TRIES, starts)):
        found.fly(rows, attempt)
        rows = np.flatnonzero(~found.reached)
        if not len(rows):
            break
    return TargetAnswers(found.reached, found.numbers, found.flown_torque, found.flown_step)


def drawn_starts(task: ReorientationTask, targets: Floats, starts: int, seed: int) -> Paths:
    """Starts (M starts) of many targets (M, 4), those of a target as for that target alone."""
    drawn = [starts_of(task.aiming_at(q), starts, seed) for q in targets]
    return Paths(*(np.concatenate(parts) for parts in zip(*drawn, strict=True)))


class _Flown:
    """The answer of every target that is best so far, flown."""

    def __init__(
        self, task: ReorientationTask, targets: Floats, solution: InteriorSolution, starts: int
    ):
        self.task, self.targets = task, targets
        finite = np.isfinite(solution.u).all(axis=(1, 2)) & np.isfinite(solution.x).all(axis=(1, 2))
        self.torque = task.torques(np.nan_to_num(solution.u))
        self.step = np.exp(np.where(finite, solution.x[:, -1, -1], 0.0))
        self.cost = task.cost(self.torque, self.step)
        self.violation = np.asarray(solution.violation)
        self.stationarity = np.asarray(solution.stationarity)
        failed = (np.asarray(solution.status) != int(Status.CONVERGED)) | ~finite
        shape = (len(targets), starts)
        order = np.lexsort((self.cost.reshape(shape), failed.reshape(shape)), axis=1)
        self.order = order + starts * np.arange(len(targets))[:, None]
        """Answers of each target from best to worst by the solver's count, (M, starts)."""
        self.reached = np.zeros(len(targets), bool)
        self.numbers: dict[str, Floats] = {}
        self.flown_torque = np.zeros((len(targets), *self.torque.shape[1:]))
        self.flown_step = np.zeros(len(targets))

    def fly(self, rows: npt.NDArray[np.int64], attempt: int) -> None:
        """Fly the answer of this rank of some targets, and note what the flights say."""
        chosen = self.order[rows, attempt]
        torque, step, task = self.torque[chosen], self.step[chosen], self.task
        flown, flight = fly_all_until_agreed(
            lambda some, times: task.fly(torque[some], step[some], times=times),
            len(rows),
            task.flight_steps,
            task.tolerances,
        )
        verdict = task.aiming_at(self.targets[rows]).judge(flown, torque, step)
        self.reached[rows] = verdict.reached & flight.agreed
        self.flown_torque[rows], self.flown_step[rows] = torque, step
        noted = {
            "final_time_s": task.intervals * step,
            "cost": self.cost[chosen],
            "attitude_error_deg": np.degrees(verdict.errors["attitude"]),
            "rate_error_rad_s": verdict.errors["rate"],
            "flight_error_deg": np.degrees(flight.attitude),
            "flight_error_rad_s": flight.rate,
            "kkt.violation": self.violation[chosen],
            "kkt.stationarity": self.stationarity[chosen],
        }
        for name, values in noted.items():
            self.numbers.setdefault(name, np.full(len(self.reached), np.nan))[rows] = values
