"""Modified Rodrigues parameters: sigma = eps / (1 + eta) = axis tan(angle / 4).

Frames follow the quaternions: R(sigma_ab) maps components in b to components in a. Each attitude
has two sets, sigma and its shadow -sigma / |sigma|^2, one inside and one outside the unit sphere.
Formulas: Schaub and Junkins, Analytical Mechanics of Space Systems, chapter 3.
"""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import broadcast_batch, cross, dot, quaternion_of, tiny, vector_of
from jaxatt.attitude.whole import compiled_whole


def from_quaternion(q: ArrayLike, *, short: bool = True) -> jax.Array:
    """MRP of a unit quaternion.

    Parameters
    ----------
    q : (..., 4)
        Unit quaternion.
    short : bool
        True takes the set with |sigma| <= 1, finite and with finite gradients for every
        attitude, and switches sets where eta passes zero. False keeps the given sign of q and
        is continuous there, but grows without bound towards eta = -1; at eta = -1 itself, where
        no finite set of that sign exists, it returns the other set, zero.

    Returns
    -------
    (..., 3)
    """
    q = quaternion.canonical(q) if short else quaternion_of(q)
    eta, eps = q[..., :1], q[..., 1:]
    forward = eps / (1 + jnp.where(eta < 0.0, 0.0, eta))
    if short:
        return forward
    # 1 + eta = |eps|^2 / (1 - eta) on the unit sphere: no cancellation near eta = -1.
    squared = dot(eps, eps)[..., None]
    vanishes = squared < tiny(q)
    backward = eps * ((1 - eta) / jnp.where(vanishes, 1.0, squared))
    return jnp.where(eta < 0.0, backward, forward)


@compiled_whole
def to_quaternion(sigma: ArrayLike) -> jax.Array:
    """Unit quaternion of an MRP; eta >= 0 exactly where |sigma| <= 1.

    Parameters
    ----------
    sigma : (..., 3)

    Returns
    -------
    (..., 4)
    """
    sigma = vector_of(sigma, "MRP")
    squared = dot(sigma, sigma)[..., None]
    return jnp.concatenate([1 - squared, 2 * sigma], axis=-1) / (1 + squared)


@compiled_whole
def shadow(sigma: ArrayLike) -> jax.Array:
    """The other MRP of the same attitude, -sigma / |sigma|^2, shape (...).

    The shadow of zero lies at infinity; zero is returned there.
    """
    sigma = vector_of(sigma, "MRP")
    squared = dot(sigma, sigma)[..., None]
    vanishes = squared < tiny(sigma)
    return -sigma / jnp.where(vanishes, 1.0, squared)


@compiled_whole
def switch(sigma: ArrayLike) -> jax.Array:
    """The set inside the unit sphere: the shadow where |sigma| > 1, else sigma itself."""
    sigma = vector_of(sigma, "MRP")
    outside = dot(sigma, sigma)[..., None] > 1.0
    # The unused branch is fed ones: the shadow of a small sigma has gradients that overflow.
    return jnp.where(outside, shadow(jnp.where(outside, sigma, 1.0)), sigma)


@compiled_whole
def to_matrix(sigma: ArrayLike) -> jax.Array:
    """Rotation matrix R(sigma), shape (..., 3, 3); the same for sigma and its shadow."""
    return quaternion.to_matrix(to_quaternion(sigma))


@compiled_whole
def multiply(sigma1: ArrayLike, sigma2: ArrayLike) -> jax.Array:
    """Compose, R(result) = R(sigma1) R(sigma2); the result is the set inside the unit sphere.

    Parameters
    ----------
    sigma1, sigma2 : (..., 3)

    Returns
    -------
    (..., 3)
    """
    return from_quaternion(quaternion.multiply(to_quaternion(sigma1), to_quaternion(sigma2)))


@compiled_whole
def derivative(sigma: ArrayLike, omega: ArrayLike) -> jax.Array:
    """Kinematics 4 dsigma/dt = [(1 - |sigma|^2) I + 2 S(sigma) + 2 sigma sigma'] omega.

    Parameters
    ----------
    sigma : (..., 3)
        `sigma_ab`, either set.
    omega : (..., 3) [rad/s]
        `omega_ab` in the axes of b.

    Returns
    -------
    (..., 3) [1/s]
    """
    sigma, omega = broadcast_batch(vector_of(sigma, "MRP"), vector_of(omega, "omega"))
    straight = (1 - dot(sigma, sigma))[..., None] * omega
    along = dot(sigma, omega)[..., None] * sigma
    return 0.25 * (straight + 2 * cross(sigma, omega) + 2 * along)
