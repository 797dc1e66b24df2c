"""Torque of the gravity gradient on a rigid body."""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.components import Matrix, Scalar, Vector
from jaxatt.attitude.vectors import broadcast_batch, cross, dot, floating, matvec
from jaxatt.environment.orbit import MU_EARTH


def gravity_gradient_torque(
    q_ob: ArrayLike, r_i: ArrayLike, inertia: ArrayLike, mu: ArrayLike = MU_EARTH
) -> jax.Array:
    """Torque 3 mu / |r|^3 c3 x J c3, c3 the orbit z axis in body axes.

    Schaanning (2021), eq. (4.11).

    Parameters
    ----------
    q_ob : (..., 4)
        Unit quaternion, body relative to orbit.
    r_i : (..., 3) [m]
        Only its length matters.
    inertia : (..., 3, 3) [kg m^2]
        J in body axes.
    mu : (...) [m^3/s^2]

    Returns
    -------
    (..., 3) [N m]
        In body axes.
    """
    q_ob = floating(q_ob)
    z_o = jnp.array([0.0, 0.0, 1.0], dtype=q_ob.dtype)
    c3 = quaternion.rotate_inverse(q_ob, z_o)
    r_i, mu = broadcast_batch(r_i, floating(mu)[..., None])
    squared = dot(r_i, r_i)[..., None]
    strength = 3 * (mu / squared) / jnp.sqrt(squared)
    torque, strength = broadcast_batch(cross(c3, matvec(inertia, c3)), strength)
    return strength * torque


def tidal_torque(down: Vector, gradient: Scalar, inertia: Matrix) -> Vector:
    """The gravity-gradient torque in components, for use inside a loop.

    down : the orbit z axis in body axes.  gradient : 3 mu / |r|^3 [1/s^2].  inertia : [kg m^2].
    """
    return down.cross(inertia @ down) * gradient
