"""Openings of valves inside control intervals: where they go, and what can be read off them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats

_SAMPLES = 200
_FULL = 1e-12


@dataclass(frozen=True, eq=False)
class Pulses:
    """One opening of every thruster in every interval, and what the wheels do meanwhile.

    opens, shuts : (N, m) [s] from the interval's start, equal where the valve stays shut.
    wheel_torque : (N, n) [N m], constant over each interval.  step : [s], length of an interval.
    """

    opens: Floats
    shuts: Floats
    wheel_torque: Floats
    step: float

    @property
    def on_time(self) -> Floats:
        """(N, m) [s], how long each valve is open."""
        return np.asarray(self.shuts - self.opens)

    def thrust(self, limit: Floats) -> tuple[Floats, Floats]:
        """Times (T,) [s] and torque of each thruster (T, m) [N m], sampled finely."""
        inner = (np.arange(_SAMPLES) + 0.5) * self.step / _SAMPLES
        count = len(self.opens)
        at = inner[None, :, None]
        is_open = (self.opens[:, None] <= at) & (at < self.shuts[:, None])
        times = (self.step * np.arange(count)[:, None] + inner[None]).ravel()
        return times, np.where(is_open, limit, 0.0).reshape(len(times), -1)


def split(pulses: Pulses, parts: int) -> Pulses:
    """The same openings, every interval cut into equal parts."""
    step = pulses.step / parts
    begins = step * np.arange(parts)[None, :, None]

    def inside(times: Floats) -> Floats:
        return np.clip(times[:, None] - begins, 0.0, step).reshape(-1, times.shape[1])

    wheel = np.repeat(pulses.wheel_torque, parts, axis=0)
    return Pulses(inside(pulses.opens), inside(pulses.shuts), wheel, step)


def anchors(duty: Floats) -> Floats:
    """Where openings for a share (N, m) of each interval belong: 0 its start, 1 its end.

    An opening that follows a valve left open starts at once; one before a valve that opens at
    once ends with the interval; others are centred, where they act most like partial torque.
    """
    whole = duty >= 1.0 - _FULL
    before = np.concatenate([np.zeros_like(whole[:1]), whole[:-1]])
    after = np.concatenate([whole[1:], np.zeros_like(whole[:1])])
    return np.where(before, 0.0, np.where(after, 1.0, 0.5))


def place(duty: Floats, anchor: Floats, wheel_torque: Floats, step: float) -> Pulses:
    """Openings for a share (N, m) of each interval, moved towards its start or end by `anchors`."""
    width = np.clip(duty, 0.0, 1.0) * step
    opens = anchor * (step - width)
    return Pulses(opens, np.minimum(opens + width, step), wheel_torque, step)


def overlaps(pulses: Pulses, pairs: tuple[tuple[int, int], ...]) -> int:
    """Intervals, over all pairs of thrusters, in which both of a pair are open at once."""
    count = 0
    for i, j in pairs:
        both = np.minimum(pulses.shuts[:, i], pulses.shuts[:, j]) - np.maximum(
            pulses.opens[:, i], pulses.opens[:, j]
        )
        count += int((both > 0.0).sum())
    return count


def partly_open(thrust: Floats, limit: Floats) -> int:
    """Samples (..., m) [N m] that are neither zero nor the limit (m,)."""
    inside = (thrust > 1e-9 * limit) & (thrust < limit * (1.0 - 1e-9))
    return int(inside.sum())
