"""Data of a turn in free time beyond what every phase has."""

from __future__ import annotations

from dataclasses import dataclass

from jaxatt.records.phase import Phase, Section
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class TimeOptimum(Section):
    """Cost, switching times and optimality of a turn in free time.

    effort_weight : rho [1/(N m)^2].  cost : [s], the programme's own.
    actuators : names, wheels then thrusters.  switch_times : (K,) [s] of each actuator.
    torque_share : largest torque of all actuators as a share of its limit.
    violation : largest violation of a constraint of the programme, and stationarity : norm of the
    gradient of its Lagrangian, both as the solver scales them.
    minima : different minima among the starts that ended well.  share : of all starts, those that
    ended at the best.
    own_error : [rad] by which the end of the transcription misses the target; that of the flight
        with fine steps stands among the phase's errors.
    start_costs, start_times : (S,) [s], cost and final time where each start ended.
    attitude, integration : of the transcription.
    resolved_time : [s], with switches between the grid's nodes; None where they were not resolved.
    """

    effort_weight: float
    cost: float
    actuators: tuple[str, ...]
    switch_times: tuple[Floats, ...]
    torque_share: float
    violation: float
    stationarity: float
    minima: int
    share: float
    own_error: float
    start_costs: Floats
    start_times: Floats
    attitude: str
    integration: str
    resolved_time: float | None = None

    @property
    def kkt(self) -> dict[str, float]:
        """Residuals of the first-order conditions of an optimum."""
        return {"violation": self.violation, "stationarity": self.stationarity}

    def __repr__(self) -> str:
        return f"TimeOptimum({self.cost:.6g} s, {100 * self.share:.0f} % of the starts)"


def time_optimum(phase: Phase) -> TimeOptimum:
    """The section of a turn in free time; `TypeError` where a phase is of another family."""
    if not isinstance(phase.section, TimeOptimum):
        raise TypeError(f"a phase of family {phase.family!r} is no turn whose time was found")
    return phase.section
