"""Thrusters that are open or shut, as they flew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from jaxatt.records.wording import plural
from jaxatt.runtime.arrays import Flags, Floats


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
