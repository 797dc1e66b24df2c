"""Record of one optimisation and of the flight that verified it, for any family."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from jaxatt.records.pointing import PointingRecord
from jaxatt.records.starts import StartsRecord
from jaxatt.records.wheel_bands import BandRecord
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.flight_error import FlightError


class Section:
    """Data that only the answers of one family have; a family derives a dataclass from it."""

    @property
    def control_unit(self) -> str:
        """Unit of the decided controls, in which what is over a limit is told."""
        return "N m"

    def headline(self, phases: Sequence[Phase]) -> str:
        """Short text of an answer for the head of a figure: its final times."""
        return ", ".join(f"{phase.final_time:.4f} s" for phase in phases)

    def brief(self, phases: Sequence[Phase]) -> str:
        """Short text of an answer for one line: the length of all phases together."""
        return f"{sum(phase.final_time for phase in phases):.6g} s"


@dataclass(frozen=True, eq=False)
class Phase:
    """Answer of one optimisation with the flight that verified it, for any family.

    family : name under which `jaxatt.problems.registry` knows the family.
    start_time, step : [s].  controls : (N, b), optimised controls (torques in body or wheel axes
    [N m], or another system's controls), thresholded.
    series : name -> array sampled in flight, with M = N + coast + 1 nodes or N intervals leading;
    for a spacecraft "q_ob" (M, 4), "omega_ob" (M, 3) [rad/s], "omega_ib" (M, 3) [rad/s],
    "omega_bw" (M, n) [rad/s], and "torque_body" (N, 3), "torque_wheels" (N, n) and
    "torque_thrusters" (N, m) [N m], the last three where there are such actuators.
    reference : name -> target of a series, e.g. "q_ob" (4,), "omega_ob" (3,).
    errors, tolerances : name -> number: "attitude" [rad], "rate" [rad/s], "waypoint" [rad] or
    others of the family's own.
    objective : named parts of the cost.
    l1_effort : L1 effort [N m s], or the integral of the absolute controls of another system.
    reached : whether the flight is within every tolerance and limit.
    failure_reason : what stood in the way if it is not, in words; empty otherwise.
    active : (N,), intervals in which a control is above the threshold.
    starts : how every start ended.
    pointing : None without cones and rate limits.
    alternative : the best answer that does reach, where the best by cost does not.
    search_steps : Runge-Kutta steps an interval of the search; 0 where they are not counted.
    flight_error : how wrong the flight can be, and its steps; None where that was not measured.
    wheel_bands : how the wheels kept to each band of speeds that they avoid.
    section : what only this family's answers have.
    """

    family: str
    start_time: float
    step: float
    controls: Floats
    series: Mapping[str, Floats]
    reference: Mapping[str, Floats]
    errors: Mapping[str, float]
    tolerances: Mapping[str, float]
    limit_violation: float
    margin_violation: float
    objective: Mapping[str, float]
    l1_effort: float
    reached: bool
    failure_reason: str
    active: Flags
    starts: StartsRecord
    pointing: PointingRecord | None = None
    alternative: Phase | None = None
    search_steps: int = 0
    flight_error: FlightError | None = None
    wheel_bands: tuple[BandRecord, ...] = ()
    section: Section = field(default_factory=Section)

    @property
    def final_time(self) -> float:
        """Length of the phase's horizon [s], without the coast after it."""
        return self.step * len(self.active)

    @property
    def quadratic_effort(self) -> float:
        """Integral of the summed squared torques of all actuators [(N m)^2 s], or of u^2."""
        names = ("torque_wheels", "torque_thrusters")
        flown = [self.series[name] for name in names if name in self.series] or [self.controls]
        return sum(squared_effort(torque, self.step) for torque in flown)

    @property
    def active_intervals(self) -> int:
        """Number of intervals in which a control is above the threshold."""
        return int(self.active.sum())

    @property
    def total_cost(self) -> float:
        """Sum of all parts of the cost."""
        return float(sum(self.objective.values()))

    @property
    def effort(self) -> float:
        """The L1 effort, under its earlier name."""
        return self.l1_effort

    @property
    def control_effort(self) -> float:
        """The quadratic effort, under its earlier name."""
        return self.quadratic_effort

    @property
    def obstacle(self) -> str:
        """The failure reason, under its earlier name."""
        return self.failure_reason

    def __repr__(self) -> str:
        reached = "reached" if self.reached else "not reached"
        return f"Phase({reached}, {self.section.brief((self,))})"


def squared_effort(torque: Floats, step: float) -> float:
    """Integral of the sum of squared torques [(N m)^2 s]; torque : (N, b) [N m], step : [s]."""
    return float(step * np.sum(torque**2))
