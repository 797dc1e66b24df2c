"""What is particular to a turn whose time was minimised, alone or with its effort."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.runtime.arrays import Floats

_SATURATED = 1e-3
"""Share of the half range within which a torque counts as at its limit."""


@dataclass(frozen=True, eq=False)
class TimeOptimum:
    """The answer beyond what every phase holds: its price, its switches and how good it is.

    effort_weight : rho [1/(N m)^2].  cost : [s], the programme's own.
    actuators : names, wheels then thrusters.  switch_times : (K,) [s] of each actuator.
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
        """How well the first-order conditions of an optimum are met."""
        return {"violation": self.violation, "stationarity": self.stationarity}

    def to_dict(self) -> dict[str, Any]:
        """The rest in plain numbers, ready for JSON."""
        return {
            "effort_weight": self.effort_weight,
            "switch_times_s": {
                name: times.tolist()
                for name, times in zip(self.actuators, self.switch_times, strict=True)
            },
            "resolved_final_time_s": self.resolved_time,
            "minima": self.minima,
            "share_at_best": self.share,
            "transcription": {
                "attitude": self.attitude,
                "integration": self.integration,
                "attitude_error_deg": float(np.degrees(self.own_error)),
            },
        }

    def __repr__(self) -> str:
        return f"TimeOptimum({self.cost:.6g} s, {100 * self.share:.0f} % of the starts)"


def switch_times(torque: Floats, edges: Floats, lower: Floats, upper: Floats) -> tuple[Floats, ...]:
    """When each torque changes from one of its limits to the other [s].

    torque : (N, b) [N m], constant in the intervals between edges (N + 1,) [s].
    lower, upper : (b,) [N m].

    Between the limits the instant is the one at which a jump would give the same impulse, so that
    a switch is known better than the length of an interval.
    """
    scaled = (2.0 * torque - upper - lower) / (upper - lower)
    found = []
    for values in scaled.T:
        side = np.where(np.abs(values) > 1.0 - _SATURATED, np.sign(values), 0.0)
        at_limit = np.flatnonzero(side)
        times = []
        for before, after in itertools.pairwise(at_limit):
            if side[before] == side[after]:
                continue
            between = slice(before + 1, after)
            kept = (values[between] - side[after]) / (side[before] - side[after])
            lengths = np.diff(edges)[between]
            times.append(float(edges[before + 1] + np.sum(kept * lengths)))
        found.append(np.array(times))
    return tuple(found)


def control_effort(torque: Floats, step: float) -> float:
    """Integral of the sum of squared torques [(N m)^2 s]; torque : (N, b) [N m], step : [s]."""
    return float(step * np.sum(torque**2))
