"""Settling time, steady error and torque of a run, accumulated sample by sample.

Nothing has to be stored: every figure is exact at the sampling instants, however few of them are
recorded.  The settling time is the instant at which the error line crosses the band, so that it
has a derivative with respect to whatever shaped the error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar, Vector

CHANNELS = ("x", "y", "z", "total")


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Band:
    """Error band that defines when a run has settled.

    width : () [rad] or [rad/s], largest absolute error of each channel.
    since : () [s], instant from which errors count, that of the command.
    """

    width: Array | float
    since: Array | float


class Channel(NamedTuple):
    """Running record of one error signal.

    crossing : [s] when it came into the band for good; -1 before it was ever outside.
    outside : its size at the last sample while it is outside, else 0.
    square : integral of its square since it settled.
    """

    crossing: Array
    outside: Array
    square: Array


class Effort(NamedTuple):
    """Running record of the torque on the wheels in body axes.

    integral : of its Euclidean norm [N m s].  peak : (x, y, z) [N m], of largest size, with sign,
    as torque on the body.
    """

    integral: Array
    peak: Vector


def channel(zero: Array) -> Channel:
    """Record of an error signal before the first sample."""
    return Channel(zero - 1.0, zero, zero)


def follow(before: Channel, error: Scalar, time: Array, period: Array, band: Band) -> Channel:
    """Update the record of an error signal with one more sample, at `time` [s]."""
    size = jnp.abs(error)
    counts = time >= band.since - 1e-9
    inside = size <= band.width
    out, entered = counts & ~inside, counts & inside & (before.outside > 0.0)
    fall = jnp.where(entered, before.outside - size, 1.0)
    fraction = (before.outside - band.width) / fall
    return Channel(
        crossing=jnp.where(entered, time + period * (fraction - 1.0), before.crossing),
        outside=jnp.where(out, size, jnp.where(counts, 0.0, before.outside)),
        square=jnp.where(out, 0.0, before.square + jnp.where(counts, period * size * size, 0.0)),
    )


def spend(before: Effort, torque: Vector, period: Array) -> Effort:
    """Update the effort with a `torque` [N m] on the wheels that was held for one period."""
    peak = before.peak.map(
        lambda most, now: jnp.where(jnp.abs(now) > jnp.abs(most), -now, most), torque
    )
    return Effort(before.integral + period * torque.norm(), peak)


class Figures(NamedTuple):
    """Settling time, errors and torque of a run; channels x, y, z and total (norm of the error).

    settling : (4,) [s] after the command; 0 where the channel never left the band, not a number
    where it ended outside.  always_inside : (4,), whether it never left.
    rms : (4,), root mean square while settled.  final : (4,), at the end.
    integral : () [N m s] of the norm of the torque.  peak : (3,) [N m], on the body.
    saturated : (), share of the time in which a dipole is at its limit.
    """

    settling: Array
    always_inside: Array
    rms: Array
    final: Array
    integral: Array
    peak: Array
    saturated: Array | float = 0.0


def figures(
    channels: tuple[Channel, ...], effort: Effort, band: Band, final: Array, end: Array
) -> Figures:
    """Figures of a finished run.

    final : (4,), errors at the end.  end : [s], when that is.
    """

    def settling(c: Channel) -> Array:
        after = jnp.where(c.crossing < 0.0, 0.0, c.crossing - band.since)
        return jnp.where(c.outside > 0.0, jnp.nan, after)

    def rms(c: Channel) -> Array:
        span = jnp.where(c.crossing < 0.0, end - band.since, end - c.crossing)
        return jnp.sqrt(c.square / jnp.maximum(span, 1e-300))

    return Figures(
        settling=jnp.stack([settling(c) for c in channels]),
        always_inside=jnp.stack([(c.crossing < 0.0) & (c.outside <= 0.0) for c in channels]),
        rms=jnp.stack([rms(c) for c in channels]),
        final=final,
        integral=effort.integral,
        peak=effort.peak.array,
    )
