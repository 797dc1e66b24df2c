"""The orbit frame: z to the Earth's centre, y against the orbit normal, x = y x z forward."""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import broadcast_batch, cross, dot


def matrix_io(r_i: ArrayLike, v_i: ArrayLike) -> jax.Array:
    """Rotation matrix R(q_io) from orbit to inertial axes, its columns x, y and z.

    Schaanning (2021), eq. (2.38) and (2.39), with x completing the frame: the velocity that the
    source takes for x is not orthogonal to z on an eccentric orbit.

    Parameters
    ----------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
        Not parallel to r_i.

    Returns
    -------
    (..., 3, 3)
    """
    r_i, v_i = broadcast_batch(r_i, v_i)
    z = -r_i / jnp.sqrt(dot(r_i, r_i))[..., None]
    momentum = cross(r_i, v_i)
    y = -momentum / jnp.sqrt(dot(momentum, momentum))[..., None]
    return jnp.stack([cross(y, z), y, z], axis=-1)


def quaternion_io(r_i: ArrayLike, v_i: ArrayLike) -> jax.Array:
    """Attitude (..., 4) of the orbit frame relative to inertial axes, with eta >= 0.

    The sign makes it jump twice a revolution, though the attitude does not.
    """
    return quaternion.from_matrix(matrix_io(r_i, v_i))


def omega_io(r_i: ArrayLike, v_i: ArrayLike, acceleration: ArrayLike | None = None) -> jax.Array:
    """Rate of the orbit frame relative to inertial, in orbit axes.

    (0, -|r x v| / |r|^2, 0) on a two-body orbit, whose plane does not turn; Schaanning (2021),
    eq. (4.4).  What pushes across the plane turns it about the position: with a_n along the normal
    the third component is -|r| a_n / |r x v|.

    Parameters
    ----------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
    acceleration : (..., 3) [m/s^2]
        None where it lies in the plane.

    Returns
    -------
    (..., 3) [rad/s]
    """
    r_i, v_i = broadcast_batch(r_i, v_i)
    momentum, squared = cross(r_i, v_i), dot(r_i, r_i)
    size = jnp.sqrt(dot(momentum, momentum))
    rate = -size / squared
    turning = jnp.zeros_like(rate)
    if acceleration is not None:
        momentum, acceleration = broadcast_batch(momentum, acceleration)
        turning = -jnp.sqrt(squared) * dot(acceleration, momentum) / size**2
    return jnp.stack([jnp.zeros_like(rate), rate, turning], axis=-1)
