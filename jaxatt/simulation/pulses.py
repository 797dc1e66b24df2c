"""Opening and shutting times of valves inside the control intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats

_SAMPLES = 200
_FULL = 1e-12


@dataclass(frozen=True, eq=False)
class Pulses:
    """One opening of every thruster in every interval, with the wheel torques.

    opens, shuts : (N, m) [s] from the interval's start, equal where the valve stays shut.
    wheel_torque : (N, n) [N m], constant over each interval.  step : [s], length of an interval.
    """

    opens: Floats
    shuts: Floats
    wheel_torque: Floats
    step: float

    @property
    def on_time(self) -> Floats:
        """Time (N, m) [s] for which each valve is open."""
        return np.asarray(self.shuts - self.opens)

    def thrust(self, limit: Floats) -> tuple[Floats, Floats]:
        """Times (T,) [s] and torque of each thruster (T, m) [N m], finely sampled."""
        inner = (np.arange(_SAMPLES) + 0.5) * self.step / _SAMPLES
        count = len(self.opens)
        at = inner[None, :, None]
        is_open = (self.opens[:, None] <= at) & (at < self.shuts[:, None])
        times = (self.step * np.arange(count)[:, None] + inner[None]).ravel()
        return times, np.where(is_open, limit, 0.0).reshape(len(times), -1)


def split(pulses: Pulses, parts: int) -> Pulses:
    """The same openings with every interval divided into equal parts."""
    step = pulses.step / parts
    begins = step * np.arange(parts)[None, :, None]

    def inside(times: Floats) -> Floats:
        return np.clip(times[:, None] - begins, 0.0, step).reshape(-1, times.shape[1])

    wheel = np.repeat(pulses.wheel_torque, parts, axis=0)
    return Pulses(inside(pulses.opens), inside(pulses.shuts), wheel, step)


def anchors(duty: Floats) -> Floats:
    """Where in its interval each opening of duty cycle (N, m) goes: 0 for the start, 1 for the end.

    An opening that follows a valve left open starts at once; one before a valve that opens at
    once ends with the interval; others are centred, where they act most like partial torque.
    """
    whole = duty >= 1.0 - _FULL
    before = np.concatenate([np.zeros_like(whole[:1]), whole[:-1]])
    after = np.concatenate([whole[1:], np.zeros_like(whole[:1])])
    return np.where(before, 0.0, np.where(after, 1.0, 0.5))


def place(duty: Floats, anchor: Floats, wheel_torque: Floats, step: float) -> Pulses:
    """Place openings of duty cycle (N, m) in their intervals as `anchors` says."""
    width = np.clip(duty, 0.0, 1.0) * step
    opens = anchor * (step - width)
    return Pulses(opens, np.minimum(opens + width, step), wheel_torque, step)


def overlaps(pulses: Pulses, pairs: tuple[tuple[int, int], ...]) -> int:
    """Count the intervals, over all pairs of thrusters, in which a pair is open at once."""
    count = 0
    for i, j in pairs:
        both = np.minimum(pulses.shuts[:, i], pulses.shuts[:, j]) - np.maximum(
            pulses.opens[:, i], pulses.opens[:, j]
        )
        count += int((both > 0.0).sum())
    return count


def partly_open(thrust: Floats, limit: Floats) -> int:
    """Count the samples (..., m) [N m] that are neither zero nor at the limit (m,)."""
    inside = (thrust > 1e-9 * limit) & (thrust < limit * (1.0 - 1e-9))
    return int(inside.sum())
