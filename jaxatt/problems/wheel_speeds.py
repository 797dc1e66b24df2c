"""Speeds that wheels may have, and how flights keep to them.

A wheel that must not enter a band of speeds stays on the side on which it begins: with the limit of
its speed that leaves a range between two speeds of any sign.
"""

from __future__ import annotations

import numpy as np
from jax import Array

from jaxatt.records.wheel_bands import BandRecord
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.spacecraft.wheels import ReactionWheels

_EDGE = 1e-6
"""Share of a speed by which a wheel must be beyond an edge to count as beyond."""


def speed_range(
    wheels: ReactionWheels,
    first: Floats | Array,
    tighter: Floats | float = 0.0,
    every_band: bool = False,
) -> tuple[Floats, Floats]:
    """Lowest and highest speed (..., n) [rad/s] of wheels that begin with the speeds `first`.

    tighter : (n,), shares by which both ends are stricter, though never than the first speed, which
    nothing changes.  every_band : whether bands that may be crossed are barred too, for the wheels
    that begin outside.
    """
    begins = np.asarray(first, float)
    upper = np.broadcast_to(np.asarray(wheels.speed_limit, float), begins.shape)
    lower = -upper
    a, b = wheels.avoid.sides
    never = np.asarray(wheels.avoid.longest_stay)[:, None, None] == 0.0
    if len(a):
        at = begins[..., None, None, :]
        barred = never | (every_band & ((at <= a) | (b <= at)))
        above = _above(at, a, b)
        lower = np.maximum(lower, np.where(barred & above, b, -np.inf).max(axis=(-3, -2)))
        upper = np.minimum(upper, np.where(barred & ~above, a, np.inf).min(axis=(-3, -2)))
    less, more = (tighter * np.where(np.isfinite(e), np.abs(e), 0.0) for e in (upper, lower))
    return (
        np.minimum(lower + more, np.maximum(begins, lower)),
        np.maximum(upper - less, np.minimum(begins, upper)),
    )


def _above(begins: Floats, a: Floats, b: Floats) -> Flags:
    """Whether a wheel begins above an interval; one inside it belongs to the nearer edge."""
    return np.asarray(begins >= 0.5 * (a + b))


def speed_excess(
    wheels: ReactionWheels, omega_bw: Floats | Array, every_band: bool = False
) -> Floats:
    """Largest way of each wheel out of its range, as a share of the speed at its end, (S, n).

    omega_bw : (S, nodes, n) [rad/s]; the first node decides the range.  Negative where it is kept,
    -1 where there is none.  every_band : as for `speed_range`.
    """
    speeds = np.asarray(omega_bw, float)
    lower, upper = speed_range(wheels, speeds[:, 0], every_band=every_band)
    above = speeds.max(axis=1) / np.abs(upper) - np.sign(upper)
    below = np.sign(lower) - speeds.min(axis=1) / np.abs(lower)
    return np.asarray(np.maximum(above, below))


def overstay(wheels: ReactionWheels, omega_bw: Floats | Array, step: Floats | float) -> Floats:
    """Excess of the longest stay in a band that is to be left over its time, as a share, (S,).

    Arguments as for `longest_stays`; 0 where all wheels leave in time.
    """
    allowed = np.asarray(wheels.avoid.longest_stay)
    timed = allowed > 0.0
    if not timed.any():
        return np.zeros(len(np.asarray(omega_bw)))
    stays = longest_stays(wheels, omega_bw, step)[:, timed]
    share = stays / allowed[timed][None, :, None] - 1.0
    return np.asarray(np.maximum(0.0, share.max(axis=(1, 2))))


def longest_stays(wheels: ReactionWheels, omega_bw: Floats | Array, step: Floats | float) -> Floats:
    """Longest time for which each wheel stays within each band, (S, m, n) [s].

    omega_bw : (S, nodes, n) [rad/s], at instants `step` [s], () or (S,), apart; in between speeds
    count as linear.  A stay that the end of the flight cuts short counts as long as it was.
    """
    speeds = np.asarray(omega_bw, float)[:, :, None, None]
    a, b = wheels.avoid.sides
    # What stays at an edge, to rounding, is not inside.
    a, b = a + _EDGE * np.abs(a), b - _EDGE * np.abs(b)
    now, change = speeds[:, :-1], np.diff(speeds, axis=1)
    steady = change == 0.0
    slope = np.where(steady, 1.0, change)
    edges = np.sort([(a - now) / slope, (b - now) / slope], axis=0)
    enters, leaves = (np.where(steady, 0.0, np.clip(edge, 0.0, 1.0)) for edge in edges)
    leaves = np.where(steady & (a < now) & (now < b), 1.0, leaves)
    longest = running = np.zeros((len(speeds), *a.shape))
    for k in range(change.shape[1]):
        entered, left = enters[:, k], leaves[:, k]
        running = np.where(entered > 0.0, 0.0, running) + np.maximum(left - entered, 0.0)
        longest = np.maximum(longest, running)
        running = np.where(left < 1.0, 0.0, running)
    stays = longest.max(axis=2, initial=0.0)
    return np.asarray(stays * np.reshape(np.asarray(step, float), (-1, 1, 1)))


def broken_speeds(
    wheels: ReactionWheels,
    omega_bw: Floats | Array,
    step: float,
    passed: Floats | Array | None = None,
) -> list[str]:
    """Words on each wheel that leaves its range in a flight, or stays in a band for too long.

    omega_bw : (nodes, n) [rad/s], at instants `step` [s] apart.  passed : (k, n), the first and the
    extreme speeds, where they are known better than by these.
    """
    speeds = np.asarray(omega_bw if passed is None else passed, float)
    limits = np.broadcast_to(np.asarray(wheels.speed_limit, float), speeds.shape[1:])
    over = np.abs(speeds).max(axis=0) / limits - 1.0
    words = [
        f"{wheels.names[i]} turns {100.0 * over[i]:.3g} % faster than its limit of "
        f"{limits[i]:g} rad/s"
        for i in np.flatnonzero(over > _EDGE)
    ]
    return words + [
        f"the wheels do not avoid {band.name}: {band.outcome}"
        for band in band_records(wheels, omega_bw, step, passed)
        if not band.satisfied
    ]


def band_records(
    wheels: ReactionWheels,
    omega_bw: Floats | Array,
    step: float,
    passed: Floats | Array | None = None,
) -> tuple[BandRecord, ...]:
    """How one flight kept to each band; arguments as for `broken_speeds`."""
    speeds, bands = np.asarray(omega_bw if passed is None else passed, float), wheels.avoid
    if not bands.count:
        return ()
    stays = longest_stays(wheels, np.asarray(omega_bw)[None], step)[0]
    a, b = bands.sides
    away = np.where(_above(speeds[0], a, b), speeds.min(axis=0) - b, a - speeds.max(axis=0))
    clearance = away.min(axis=1)
    return tuple(
        BandRecord(
            f"{name} rad/s",
            float(allowed),
            stay,
            clear,
            _kept(high, allowed, stay, clear),
            wheels.names,
        )
        for name, high, allowed, stay, clear in zip(
            bands.names,
            np.asarray(bands.fastest),
            np.asarray(bands.longest_stay),
            stays,
            clearance,
            strict=True,
        )
    )


def _kept(fastest: Floats, allowed: float, stays: Floats, clearance: Floats) -> bool:
    """Whether all wheels kept to a band, to one millionth; arguments as of `BandRecord`."""
    if allowed > 0.0:
        return bool((stays <= allowed * (1.0 + _EDGE)).all())
    return bool((clearance >= -_EDGE * fastest).all())
