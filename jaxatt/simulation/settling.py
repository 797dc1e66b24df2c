"""Settling, steady error and torque of a run, gathered sample by sample.

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

from jaxatt.attitude.components import Vector

CHANNELS = ("x", "y", "z", "total")


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Band:
    """When a run counts as settled.

    width : () [rad] or [rad/s], largest absolute error of each channel.
    since : () [s], instant from which errors count, that of the command.
    """

    width: Array | float
    since: Array | float


class Channel(NamedTuple):
    """One error signal.

    crossing : [s] when it came into the band for good.  pending : 1 while it is outside.
    outside : its size at the last sample outside.  square, samples : over the samples since it
    settled.  ever : 1 once it was outside.  last : its latest value.
    """

    crossing: Array
    pending: Array
    outside: Array
    square: Array
    samples: Array
    ever: Array
    last: Array


class Effort(NamedTuple):
    """Torque on the wheels in body axes.

    integral : of its Euclidean norm [N m s].  peak : (x, y, z) [N m], of largest size, with sign,
    as torque on the body.
    """

    integral: Array
    peak: Vector


def channel(zero: Array) -> Channel:
    """Before the first sample."""
    return Channel(*(zero for _ in Channel._fields))


def follow(before: Channel, error: Array, time: Array, period: Array, band: Band) -> Channel:
    """After one more sample, at `time` [s]."""
    size = jnp.abs(error)
    counts = time >= band.since - 1e-9
    out = counts & ~(size <= band.width)
    into = counts & (size <= band.width)
    entered = into & (before.pending > 0.5)
    fall = jnp.where(entered, before.outside - size, 1.0)
    fraction = (before.outside - band.width) / jnp.where(fall > 0.0, fall, 1.0)
    crossing = jnp.where(entered, time - period * (1.0 - fraction), before.crossing)
    one = jnp.ones_like(size)
    return Channel(
        crossing=crossing,
        pending=jnp.where(out, one, jnp.where(into, 0.0 * one, before.pending)),
        outside=jnp.where(out, size, before.outside),
        square=jnp.where(out, 0.0, before.square + jnp.where(into, size**2, 0.0)),
        samples=jnp.where(out, 0.0, before.samples + jnp.where(into, 1.0, 0.0)),
        ever=jnp.where(out, one, before.ever),
        last=error,
    )


def spend(before: Effort, torque: Vector, period: Array) -> Effort:
    """After `torque` [N m] on the wheels was held for one period."""
    peak = before.peak.map(
        lambda most, now: jnp.where(jnp.abs(now) > jnp.abs(most), -now, most), torque
    )
    return Effort(before.integral + period * torque.norm(), peak)


class Figures(NamedTuple):
    """What a run came to; channels x, y, z and total (Euclidean norm of the error).

    settling : (4,) [s] after the command; 0 where the channel never left the band, not a number
    where it ended outside.  always_inside : (4,), whether it never left.
    rms : (4,), root mean square while settled.  final : (4,), at the last sample.
    integral : () [N m s] of the norm of the torque.  peak : (3,) [N m], on the body.
    """

    settling: Array
    always_inside: Array
    rms: Array
    final: Array
    integral: Array
    peak: Array


def figures(channels: tuple[Channel, ...], effort: Effort, band: Band) -> Figures:
    """Figures of a finished run."""

    def settling(c: Channel) -> Array:
        inside = jnp.where(c.ever > 0.5, c.crossing - band.since, 0.0 * c.crossing)
        return jnp.where(c.pending > 0.5, jnp.nan, inside)

    return Figures(
        settling=jnp.stack([settling(c) for c in channels]),
        always_inside=jnp.stack([c.ever < 0.5 for c in channels]),
        rms=jnp.stack([jnp.sqrt(c.square / jnp.maximum(c.samples, 1.0)) for c in channels]),
        final=jnp.stack([c.last for c in channels]),
        integral=effort.integral,
        peak=effort.peak.array,
    )
