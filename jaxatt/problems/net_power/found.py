"""Answers of a search, before and after they were flown again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, WheelLimits
from jaxatt.problems.verdict import Verdict
from jaxatt.runtime.arrays import Flags, Floats

SAME = 1e-4
"""Difference of net energies, as a share of what is gained, up to which two are one minimum."""


@dataclass(frozen=True, eq=False)
class Solved:
    """Answers of a solver to one manoeuvre from S starts.

    torque : (S, N, n) [N m].  dipole : (S, N, 3) [A m^2], or None where it was not decided.
    claimed : (S,) [J], net energy by the solver's own count.
    status : (S,) `Status`.  violation, stationarity : (S,).  iterations : (S,).
    refined : (S,), whether they were solved on the manoeuvre's own intervals, not on longer ones
    alone; None where all were.
    substeps : steps of the motion an interval that the solver took.
    limits : of the wheels, that it kept to; None where it did not count them.
    law : flight of the PD law beside the answers, where the search has flown it for them alone.
    """

    torque: Floats
    dipole: Floats | None
    claimed: Floats
    status: npt.NDArray[np.int64]
    violation: Floats
    stationarity: Floats
    iterations: npt.NDArray[np.int64]
    refined: Flags | None = None
    substeps: int = 1
    limits: WheelLimits | None = None
    law: PoweredFlight | None = None

    def pick(self, rows: npt.NDArray[np.int64]) -> Solved:
        """Answers of some of the starts."""
        dipole = None if self.dipole is None else self.dipole[rows]
        return Solved(
            self.torque[rows],
            dipole,
            self.claimed[rows],
            self.status[rows],
            self.violation[rows],
            self.stationarity[rows],
            self.iterations[rows],
            None if self.refined is None else self.refined[rows],
            self.substeps,
            self.limits,
        )

    def joined(self, other: Solved) -> Solved:
        """These answers, then others to the same manoeuvre."""

        def both(a: Any, b: Any) -> Any:
            return None if a is None or b is None else np.concatenate([a, b])

        refined = None
        if self.refined is not None:
            refined = both(self.refined, np.ones(len(other.status), bool))
        return replace(
            self,
            torque=both(self.torque, other.torque),
            dipole=both(self.dipole, other.dipole),
            claimed=both(self.claimed, other.claimed),
            status=both(self.status, other.status),
            violation=both(self.violation, other.violation),
            stationarity=both(self.stationarity, other.stationarity),
            iterations=both(self.iterations, other.iterations),
            refined=refined,
        )

    def replaced(self, rows: npt.NDArray[np.int64], by: Solved) -> Solved:
        """Answers with those of some starts refined, and the passes of both added up."""

        def put(old: Any, new: Any) -> Any:
            whole = old.copy()
            whole[rows] = new
            return whole

        return Solved(
            put(self.torque, by.torque),
            None if self.dipole is None else put(self.dipole, by.dipole),
            put(self.claimed, by.claimed),
            put(self.status, by.status),
            put(self.violation, by.violation),
            put(self.stationarity, by.stationarity),
            put(self.iterations, self.iterations[rows] + by.iterations),
            put(np.zeros(len(self.status), bool), True),
            by.substeps,
            by.limits,
        )


@dataclass(frozen=True, eq=False)
class Flown:
    """Answers with their fine flights and verdicts, and the best of them.

    score : (S,), what the answers are ranked by, the most first; [J], or [W] for mean power.
    best : index of the answer.  minima : different ones among the starts that reached,
    or whose errors are weighed.  share : of all starts, those of these at the best.
    notes : what else is worth telling where the best did not reach.
    """

    manoeuvre: Manoeuvre
    solved: Solved
    flight: PoweredFlight
    verdict: Verdict
    score: Floats
    best: int
    minima: int
    share: float
    notes: tuple[str, ...] = ()

    @property
    def reached(self) -> Flags:
        """Whether each flight reached, (S,)."""
        return self.verdict.reached


def ranked(
    manoeuvre: Manoeuvre,
    solved: Solved,
    flight: PoweredFlight,
    verdict: Verdict,
    score: Floats,
    scale: float,
    weighed: bool = False,
) -> Flown:
    """Choose the best of the answers that reached, or the nearest where none did.

    scale : of the score, against which differences are small.
    weighed : whether the score weighs the errors at the end, so that the best may miss.
    """
    usable = np.where(np.isfinite(score), score, -np.inf)
    missed = np.where(verdict.reached, 0.0, np.maximum(1.0, verdict.shortfall))
    if weighed:
        kept = verdict.within_limits & (verdict.margin_violation <= verdict.MARGIN_TOLERANCE)
        missed = np.where(kept, 0.0, missed)
    # Of answers that do not reach the nearest; of those that violate a limit alone, any.
    best = int(np.lexsort((-usable, missed))[0])
    same = SAME * scale
    counted = (missed <= 0.0) & np.isfinite(usable)
    minima = int(counted.any()) + int((np.diff(np.sort(usable[counted])) > same).sum())
    near = counted & (usable >= usable[best] - same)
    return Flown(manoeuvre, solved, flight, verdict, score, best, minima, float(near.mean()))


def converged(solved: Solved) -> Flags:
    """Whether each start ended at a minimum of its own, (S,)."""
    return np.asarray(solved.status == int(Status.CONVERGED))
