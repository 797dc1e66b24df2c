"""Measures of how well an attitude was held, and of how densely a camera samples the ground."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import errors, quaternion
from jaxatt.attitude.vectors import matvec
from jaxatt.environment import ellipsoid, epoch, frames
from jaxatt.environment.motion import Motion
from jaxatt.environment.precession import earth_fixed


def rmsd(values: ArrayLike, reference: ArrayLike) -> jax.Array:
    """Root-mean-square deviation of each component over time; Kristiansen (2023), eq. (12.4).

    values, reference : (T, ...), in one unit, which the result (...) has.
    """
    difference = jnp.asarray(reference) - jnp.asarray(values)
    return jnp.sqrt(jnp.mean(difference**2, axis=0))


def quaternion_accuracy(q: ArrayLike, q_ref: ArrayLike) -> tuple[jax.Array, jax.Array]:
    """Mean distance of attitudes (T, 4) from a reference, as printed and as an angle [rad].

    The first is the mean of arccos |q' q_ref|, Kristiansen (2023), eq. (12.5), which is half the
    angle of rotation; the second is the mean angle itself, twice that.
    """
    angle = jnp.mean(errors.angle(q_ref, q))
    return 0.5 * angle, angle


def footprints(
    motion: Motion,
    days: ArrayLike,
    times: ArrayLike,
    q_ob: ArrayLike,
    boresight: Sequence[float] = (0.0, 0.0, 1.0),
) -> jax.Array:
    """Ground points (T, 3) [m] in the camera's line of sight, Earth-fixed on the WGS 84 ellipsoid.

    days : time zero of the motion, since J2000.  times : (T,) [s] after it.
    q_ob : (T, 4).  boresight : (3,), in body axes.
    """
    times = jnp.asarray(times)
    r_i, v_i, _ = motion.at(times)
    q_ib = quaternion.multiply(frames.quaternion_io(r_i, v_i), q_ob)
    looking = quaternion.rotate(q_ib, jnp.broadcast_to(jnp.asarray(boresight), r_i.shape))
    turn = earth_fixed(jnp.asarray(days) + times / epoch.SECONDS_PER_DAY)
    return ellipsoid.ground_point(matvec(turn, r_i), matvec(turn, looking))


def sampling_distance(points: ArrayLike) -> jax.Array:
    """Ground sampling distance (T - 1,) [m] along track, between successive points (T, 3)."""
    return jnp.linalg.norm(jnp.diff(jnp.asarray(points), axis=0), axis=-1)
