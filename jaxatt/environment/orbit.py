"""Two-body motion in the inertial frame, propagated in closed form on elliptic orbits."""

import math

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch, dot, floating

MU_EARTH = 3.986004418e14
"""Standard gravitational parameter of the Earth [m^3/s^2]."""

_SOLVER_STEPS = 24


def two_body_acceleration(r_i: ArrayLike, mu: ArrayLike = MU_EARTH) -> jax.Array:
    """Acceleration -mu r / |r|^3; Schaanning (2021), eq. (4.5).

    Parameters
    ----------
    r_i : (..., 3) [m]
    mu : (...) [m^3/s^2]

    Returns
    -------
    (..., 3) [m/s^2]
    """
    r_i, mu = broadcast_batch(r_i, floating(mu)[..., None])
    radius = jnp.sqrt(dot(r_i, r_i))[..., None]
    # mu / r^2 first: mu r / r^3 leaves little of the range of float32 to spare.
    return -(mu / radius**2) * (r_i / radius)


def mean_motion(semi_major_axis: ArrayLike, mu: ArrayLike = MU_EARTH) -> jax.Array:
    """Mean motion sqrt(mu / a^3) [rad/s] of an ellipse, both arguments and result (...)."""
    a = floating(semi_major_axis)
    return jnp.sqrt(mu / a) / a


def propagate(
    r_i: ArrayLike, v_i: ArrayLike, dt: ArrayLike, mu: ArrayLike = MU_EARTH
) -> tuple[jax.Array, jax.Array]:
    """Propagate position and velocity along an elliptic orbit by a time of either sign.

    Kepler's equation is solved for the change of eccentric anomaly x,
    x - (e cos E0) sin x + (e sin E0) (1 - cos x) = n dt, which needs no perigee and so holds for
    circular orbits too; Lagrange's f and g then give the state. The iterations themselves are
    not differentiated: two Newton steps from the root carry derivatives up to the third order.

    Parameters
    ----------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
    dt : (...) [s]
        Whole revolutions are taken off, so its rounding is all that a long time costs.
    mu : (...) [m^3/s^2]

    Returns
    -------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
        Not a number where the orbit is not elliptic.
    """
    r_i, v_i, dt, mu = broadcast_batch(r_i, v_i, floating(dt)[..., None], floating(mu)[..., None])
    radius = jnp.sqrt(dot(r_i, r_i))[..., None]
    a = 1 / (2 / radius - dot(v_i, v_i)[..., None] / mu)
    root_mu_a = jnp.sqrt(mu * a)
    e_cos = 1 - radius / a
    e_sin = dot(r_i, v_i)[..., None] / root_mu_a

    mean_change = mean_motion(a, mu) * dt
    mean_change -= 2 * math.pi * jax.lax.stop_gradient(jnp.round(mean_change / (2 * math.pi)))
    x = _solve_kepler(mean_change, e_cos, e_sin)

    sin_x, one_minus_cos = jnp.sin(x), 2 * jnp.sin(x / 2) ** 2
    new_radius = a * (1 - e_cos * jnp.cos(x) + e_sin * sin_x)
    f = 1 - (a / radius) * one_minus_cos
    g = (a / root_mu_a) * (radius * sin_x + a * e_sin * one_minus_cos)
    f_dot = -(root_mu_a / radius) * sin_x / new_radius
    g_dot = 1 - (a / new_radius) * one_minus_cos
    return f * r_i + g * v_i, f_dot * r_i + g_dot * v_i


def _kepler_residual(
    x: jax.Array, mean: jax.Array, e_cos: jax.Array, e_sin: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Residual of Kepler's equation in the change of eccentric anomaly, and its derivative r/a."""
    residual = x - e_cos * jnp.sin(x) + e_sin * 2 * jnp.sin(x / 2) ** 2 - mean
    slope = 1 - e_cos * jnp.cos(x) + e_sin * jnp.sin(x)
    return residual, slope


def _solve_kepler(mean: jax.Array, e_cos: jax.Array, e_sin: jax.Array) -> jax.Array:
    """Root of the residual by Newton's method inside a bracket, all arrays (...) [rad]."""
    fixed = jax.lax.stop_gradient((mean, e_cos, e_sin))

    def step(
        _: int, state: tuple[jax.Array, jax.Array, jax.Array]
    ) -> tuple[jax.Array, jax.Array, jax.Array]:
        x, low, high = state
        residual, slope = _kepler_residual(x, *fixed)
        low = jnp.where(residual < 0.0, x, low)
        high = jnp.where(residual > 0.0, x, high)
        newton = x - residual / slope
        # Monotone residual: a step that leaves the bracket is replaced by its middle.
        return jnp.where((newton < low) | (newton > high), 0.5 * (low + high), newton), low, high

    mean_fixed, e_cos_fixed, e_sin_fixed = fixed
    reach = 2 * jnp.sqrt(e_cos_fixed**2 + e_sin_fixed**2)
    bracket = (mean_fixed, mean_fixed - reach, mean_fixed + reach)
    root, _, _ = jax.lax.fori_loop(0, _SOLVER_STEPS, step, bracket)
    x: jax.Array = jax.lax.stop_gradient(root)
    for _ in range(2):
        residual, slope = _kepler_residual(x, mean, e_cos, e_sin)
        x = x - residual / slope
    return x
