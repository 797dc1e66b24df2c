"""What a solve returns: plain arrays and numbers, labelled, with what made them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from jaxatt.problems.pointing.watch import Extreme
from jaxatt.problems.scenario import Scenario
from jaxatt.report.time_optimum import TimeOptimum, control_effort
from jaxatt.report.wording import indices_text, plural
from jaxatt.runtime.arrays import Flags, Floats

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class StartsRecord:
    """How every start ended; leading axis S.

    status : (S,) `jaxatt.optimize.status.Status`.  reached : (S,), by re-simulation.
    active_intervals : (S,).  effort : (S,), L1 effort.  long_way : (S,).  iterations : (S,).
    shortfall : (S,), largest error in units of its tolerance.
    distinct_minima : different answers among the starts that reached the target.
    """

    status: npt.NDArray[np.int64]
    reached: Flags
    active_intervals: npt.NDArray[np.int64]
    effort: Floats
    long_way: Flags
    iterations: npt.NDArray[np.int64]
    shortfall: Floats
    distinct_minima: int

    def __repr__(self) -> str:
        return f"StartsRecord({int(self.reached.sum())} of {len(self.reached)} reached)"


@dataclass(frozen=True, eq=False)
class Valves:
    """An answer whose thrusters are open or shut, as it flew.

    mode : "pulse-width" or "interval".  opens, shuts : (N, m) [s] from each interval's start.
    q_ob : (M, 4), omega_ob : (M, 3) [rad/s] at the M nodes of the flight.
    errors : "attitude" [rad] and "rate" [rad/s].  reached : whether within tolerance.
    active : (N,), intervals with any torque.  on_time : (m,) [s].
    partly_open : sampled torques that are neither zero nor the limit.
    opposed : intervals in which opposed thrusters are open together.
    failure_reason : which cones and rate limits it breaks, in words; empty where none.
    """

    mode: str
    opens: Floats
    shuts: Floats
    q_ob: Floats
    omega_ob: Floats
    errors: Mapping[str, float]
    reached: bool
    active: Flags
    on_time: Floats
    partly_open: int
    opposed: int
    failure_reason: str = ""

    def __repr__(self) -> str:
        count = plural(int(self.active.sum()), "active interval")
        return f"Valves({self.mode}, {'reached' if self.reached else 'not reached'}, {count})"


@dataclass(frozen=True, eq=False)
class PointingRecord:
    """How a phase kept to its cones and rate limits, at every Runge-Kutta step of its flight.

    time : (T,) [s] from the phase's start, the coast included.
    angles : (T, m) [rad], of m cones.  boresights, directions : (T, m, 3), in inertial axes.
    extremes : the worst instant before the end of the horizon, one a cone, then of the rate.
    constraint_margin : by how much the search took the cones stricter than they are, (m,) [rad].
    """

    time: Floats
    angles: Floats
    boresights: Floats
    directions: Floats
    extremes: tuple[Extreme, ...]
    constraint_margin: Floats


@dataclass(frozen=True, eq=False)
class FinalTimes:
    """The final times that were tried where it is free; leading axis K, in the order of trying.

    time_weight : [1/s], cost of a second in active intervals.  cost : of the answer, with its time.
    final_time : (K,) [s].  costs : (K,), infinite where nothing reached.  active_intervals,
    reached : (K,), of the best answer there.  how : K words, see
    `jaxatt.problems.hands_off.search.time_cost`.
    """

    time_weight: float
    cost: float
    final_time: Floats
    costs: Floats
    active_intervals: npt.NDArray[np.int64]
    reached: Flags
    how: tuple[str, ...]

    def __repr__(self) -> str:
        return f"FinalTimes({plural(len(self.how), 'trial')}, cost {self.cost:.6g})"


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


@dataclass(frozen=True, eq=False)
class Result:
    """The answer to a scenario: one phase, or several flown one after another.

    status : "reached" or "not reached".  time : seconds spent on "compile", "solve", "verify".
    """

    scenario: Scenario
    phases: tuple[Phase, ...]
    seed: int
    time: Mapping[str, float]
    device: str
    precision: str
    versions: Mapping[str, str]
    notes: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)

    @property
    def legs(self) -> tuple[Phase, ...]:
        """The phases, by their earlier name."""
        return self.phases

    @property
    def reached(self) -> bool:
        """Whether every phase verifiably reached its target."""
        return all(phase.reached for phase in self.phases)

    @property
    def status(self) -> str:
        """ "reached" or "not reached"."""
        return "reached" if self.reached else "not reached"

    @property
    def active_intervals(self) -> int:
        """Active intervals of all phases together."""
        return sum(phase.active_intervals for phase in self.phases)

    def summary(self) -> dict[str, Any]:
        """Plain numbers under stable names, ready for JSON."""
        from jaxatt.report.summary import summary

        return summary(self)

    def to_dataset(self) -> xarray.Dataset:
        """Labelled arrays, SI units and radians, with what made them as attributes."""
        from jaxatt.report.dataset import to_dataset

        return to_dataset(self)

    def plot(self) -> Figure:
        """Overview figure: every quantity over time, and how all starts ended."""
        from jaxatt.report.plots import plot

        return plot(self)

    def save(self, folder: str | Path) -> list[Path]:
        """Write summary.json, result.nc and the figures into a folder; return the files.

        Raises `OutputError` (a `ValueError`) where nothing can be written.
        """
        from jaxatt.report.folder import save

        return save(self, folder)

    def __repr__(self) -> str:
        if any(phase.time_optimum is not None for phase in self.phases):
            total = sum(phase.final_time for phase in self.phases)
            return f"Result({self.scenario.name}: {self.status}, {total:.6g} s)"
        count = plural(self.active_intervals, "active interval")
        found = (indices_text(np.flatnonzero(phase.active).tolist()) for phase in self.phases)
        return f"Result({self.scenario.name}: {self.status}, {count}: {' | '.join(found)})"

    def __str__(self) -> str:
        from jaxatt.report.rendering import as_text
        from jaxatt.report.tables import result_table

        return as_text(result_table(self))

    def _repr_html_(self) -> str:
        from jaxatt.report.rendering import as_html
        from jaxatt.report.tables import result_table

        return as_html(result_table(self))
