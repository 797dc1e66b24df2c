"""Data that only an answer of sparse control has: windows, valves, final times that were tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.problems.hands_off.null_torque import NullTorque
from jaxatt.records.phase import Phase, Section
from jaxatt.records.wording import indices_text, plural
from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class Valves:
    """Flight of an answer whose thrusters are fully open or shut.

    mode : "pulse-width" or "interval".  opens, shuts : (N, m) [s] from each interval's start.
    q_ob : (M, 4), omega_ob : (M, 3) [rad/s] at the M nodes of the flight.
    errors : "attitude" [rad] and "rate" [rad/s].  reached : whether within tolerance.
    active : (N,), intervals with any torque.  on_time : (m,) [s].
    partly_open : sampled torques that are neither zero nor the limit.
    opposed : intervals in which opposed thrusters are open together.
    failure_reason : which cones and rate limits it breaks, and whether the flight is too uncertain
        to tell, in words; empty where none.
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
class FinalTimes:
    """Final times that were tried where it is free; leading axis K, in the order of trying.

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
class SparseSection(Section):
    """Data of a phase of sparse control beyond what every phase has.

    weight : (N,), h_k.  window : (N,), intervals in a cheap window.
    forbidden : (N,), intervals where torque is not allowed.
    max_complementarity : largest product of a control and its complementarity variable.
    quantised : the answer with thrusters fully open or shut, as the scenario asks for, then the
        other way; empty without thrusters, or where it asks for none.
    final_times : the final times that were tried; None where it was fixed.
    bias : torques for the wheels' bias at the end; None where none is asked for.
    """

    weight: Floats
    window: Flags
    forbidden: Flags
    max_complementarity: float
    quantised: tuple[Valves, ...] = ()
    final_times: FinalTimes | None = None
    bias: NullTorque | None = None

    def weighted(self, active: Flags) -> float:
        """Sum of h_k over active intervals (N,)."""
        return float(self.weight[active].sum())

    def outside_windows(self, active: Flags) -> int:
        """Number of active intervals (N,) outside every cheap window."""
        return int((active & ~self.window).sum())

    def headline(self, phases: Sequence[Phase]) -> str:
        """Text of the number of active intervals."""
        return plural(sum(phase.active_intervals for phase in phases), "active interval")

    def brief(self, phases: Sequence[Phase]) -> str:
        """Text of the number of active intervals and of their indices, phase by phase."""
        found = (indices_text(np.flatnonzero(phase.active).tolist()) for phase in phases)
        return f"{self.headline(phases)}: {' | '.join(found)}"


def sparse_section(phase: Phase) -> SparseSection:
    """The section of a phase of sparse control; `TypeError` where it is of another family."""
    if not isinstance(phase.section, SparseSection):
        raise TypeError(f"a phase of family {phase.family!r} is no answer of sparse control")
    return phase.section
