"""Answers of a solver to a manoeuvre in free time, and what they cost when they are flown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from jaxatt.optimize.interior_point.solver import InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.magnetic.batch import Claims, claims, kept_finite, own_power
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.starts import Starts
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.runtime.arrays import Flags, Floats

_USELESS = 1e100
"""Cost that stands for none, in any units."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Answers:
    """Answers, leading axis A; one may be flown for any weight of time.

    u : (A, N, 3), dipoles in units of their limits.  x : (A, N + 1, 8), states of the programme.
    reference : (A, 4), as in `Starts`.  final_time : (A,) [s].
    claimed : (A,) [W], mean power by the solver's own count.
    flown : with finer steps and sharp edges of the shadow.
    status : (A,) `Status`.  violation, stationarity : (A,).  iterations : (A,), of all solves.
    origin : (A,), index of the start that an answer goes back to.
    """

    u: Floats
    x: Floats
    reference: Floats
    final_time: Floats
    claimed: Floats
    flown: Claims
    status: npt.NDArray[np.int64]
    violation: Floats
    stationarity: Floats
    iterations: npt.NDArray[np.int64]
    origin: npt.NDArray[np.int64]

    def pick(self, rows: Any) -> Answers:
        """Some of the answers."""
        chosen: Answers = jax.tree.map(lambda leaf: np.asarray(leaf)[rows], self)
        return chosen

    def starts(self, time_weight: Floats) -> Starts:
        """Starts from the answers, with weights of time (A,)."""
        return Starts(self.u, self.x, self.reference, np.asarray(time_weight, float))

    @staticmethod
    def join(parts: list[Answers]) -> Answers:
        """Several batches of answers as one."""
        joined: Answers = jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)
        return joined

    @property
    def disagreement(self) -> Floats:
        """Relative difference of claimed and flown energy, (A,)."""
        size = np.maximum(np.abs(self.flown.mean_power), np.finfo(float).tiny)
        return np.abs(self.claimed - self.flown.mean_power) / size

    def cost(self, task: MagneticTask, time_weight: float | Floats) -> Floats:
        """Cost of the flights (A,), in the units of the manoeuvre's own."""
        m, flown, final = task.manoeuvre, self.flown, self.final_time
        earned = flown.mean_power * (1.0 if m.cost == "mean-power" else final)
        cost = time_weight * final - earned
        if m.terminal == "penalty":
            cost = cost + m.attitude_weight * flown.turned + m.rate_weight * flown.rate
        return np.where(np.isfinite(cost), cost, _USELESS)

    def shortfall(self, task: MagneticTask) -> Floats:
        """Largest error at the end in units of its tolerance, (A,)."""
        target = task.manoeuvre.target
        angle = 2.0 * np.arccos(np.clip(1.0 - self.flown.turned, -1.0, 1.0))
        rate = np.sqrt(self.flown.rate)
        worst = np.maximum(angle / target.attitude_tolerance, rate / target.rate_tolerance)
        return np.where(np.isfinite(worst), worst, np.inf)

    def merit(self, task: MagneticTask, time_weight: float | Floats) -> Floats:
        """What answers are ranked by, the least first: of those that must reach, the reached."""
        cost = self.cost(task, time_weight)
        if task.manoeuvre.terminal == "penalty":
            return cost
        missed = self.shortfall(task)
        return np.where(missed <= 1.0, cost, _USELESS * np.minimum(missed, _USELESS))


def answers_of(
    form: MagneticForm,
    starts: Starts,
    found: InteriorSolution,
    parameters: MagneticParameters,
    before: Answers | None = None,
) -> Answers:
    """Answers of a solve from `starts`, flown.

    before : answers that the starts were made of, whose iterations count, too.
    """
    finite, u, x = kept_finite(starts, found)
    final = np.exp(x[:, -1, -1])
    status = np.where(finite, found.status, int(Status.NOT_FINITE))
    iterations = np.asarray(found.iterations)
    return Answers(
        u,
        x,
        np.asarray(starts.reference),
        final,
        own_power(form, u, x, parameters),
        claims(form, u, final, parameters),
        status,
        np.asarray(found.violation),
        np.asarray(found.stationarity),
        iterations if before is None else iterations + before.iterations,
        np.arange(len(u)) if before is None else before.origin,
    )


def distinct(values: Floats, times: Floats, most: int) -> npt.NDArray[np.int64]:
    """Indices of the least values, at most so many, without those that are the same answer.

    Those that are not finite are left out; where none is, the first one is returned.
    """
    kept: list[int] = []
    for k in np.argsort(values, kind="stable"):
        if kept and not np.isfinite(values[k]):
            break
        same = (
            abs(values[k] - values[other]) <= 1e-5 * abs(values[other])
            and abs(times[k] - times[other]) < 1e-3 * times[other]
            for other in kept
        )
        if not any(same):
            kept.append(int(k))
        if len(kept) == most:
            break
    return np.asarray(kept, int)


def usable(found: Answers) -> Flags:
    """Answers that a solve may go on from, (A,)."""
    return np.isfinite(found.flown.mean_power) & (found.violation < 1.0)
