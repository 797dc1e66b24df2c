"""The answer of one optimisation, flown again: plain arrays and numbers, labelled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.records.final_times import FinalTimes
from jaxatt.records.pointing import PointingRecord
from jaxatt.records.starts import StartsRecord
from jaxatt.records.time_optimum import TimeOptimum, control_effort
from jaxatt.records.valves import Valves
from jaxatt.records.wording import indices_text, plural
from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class Phase:
    """One optimisation, flown again.

    start_time, step : [s].  controls : (N, b), optimised controls (torques in body or wheel axes
    [N m], or a toy's control), thresholded.  weight : (N,), h_k.  window : (N,), intervals in a
    cheap window.  forbidden : (N,), intervals where torque is not allowed.
    series : name -> array sampled in flight; for a spacecraft "q_ob" (M, 4), "omega_ob" (M, 3)
    [rad/s], "omega_ib" (M, 3) [rad/s], "omega_bw" (M, n) [rad/s] at the M = N + coast + 1 nodes,
    "torque_body" (N, 3), "torque_wheels" (N, n) and "torque_thrusters" (N, m) [N m], the last three
    where there are such actuators; for a toy "state" (N + 1, 2) and
    "control" (N, 1).
    reference : name -> target of a series, e.g. "q_ob" (4,), "omega_ob" (3,), "state" (2,).
    errors, tolerances : name -> number: "attitude" [rad], "rate" [rad/s], "waypoint" [rad] or
    "state".
    objective : named parts of the printed cost.
    effort : L1 effort [N m s], or the integral of a toy's |u|.
    reached : whether the flight is within every tolerance and limit.
    failure_reason : what stood in the way if it is not, in words; empty otherwise.
    starts : how every start ended.
    alternative : in penalty mode, the best answer that does reach, where the best by cost does not.
    quantised : the answer with thrusters fully open or shut, as the scenario asks for, then the
        other way; empty without thrusters, or where it asks for none.
    final_times : the final times that were tried; None where it was fixed.
    pointing : None without cones and rate limits.
    time_optimum : where time was minimised, what is particular to that; None otherwise.
    """

    start_time: float
    step: float
    controls: Floats
    weight: Floats
    window: Flags
    forbidden: Flags
    series: Mapping[str, Floats]
    reference: Mapping[str, Floats]
    errors: Mapping[str, float]
    tolerances: Mapping[str, float]
    limit_violation: float
    margin_violation: float
    max_complementarity: float
    objective: Mapping[str, float]
    effort: float
    reached: bool
    failure_reason: str
    active: Flags
    starts: StartsRecord
    alternative: Phase | None = None
    quantised: tuple[Valves, ...] = ()
    final_times: FinalTimes | None = None
    pointing: PointingRecord | None = None
    time_optimum: TimeOptimum | None = None

    @property
    def final_time(self) -> float:
        """Length of the phase's horizon [s], without what coasts after it."""
        return self.step * len(self.active)

    @property
    def control_effort(self) -> float:
        """Integral of the summed squared torques of all actuators [(N m)^2 s], or a toy's u^2."""
        names = ("torque_wheels", "torque_thrusters", "control")
        flown = [self.series[name] for name in names if name in self.series]
        return sum(control_effort(torque, self.step) for torque in flown)

    @property
    def active_intervals(self) -> int:
        """Number of intervals in which a control is above the threshold."""
        return int(self.active.sum())

    @property
    def weighted_active_intervals(self) -> float:
        """Sum of h_k over the active intervals."""
        return float(self.weight[self.active].sum())

    @property
    def active_outside_windows(self) -> int:
        """Active intervals outside every cheap window."""
        return int((self.active & ~self.window).sum())

    @property
    def total_cost(self) -> float:
        """The printed cost, all parts together."""
        return float(sum(self.objective.values()))

    def __repr__(self) -> str:
        reached = "reached" if self.reached else "not reached"
        if self.time_optimum is not None:
            return f"Leg({reached}, {self.final_time:.6g} s)"
        count = plural(self.active_intervals, "active interval")
        return f"Leg({reached}, {count}: {indices_text(np.flatnonzero(self.active).tolist())})"
