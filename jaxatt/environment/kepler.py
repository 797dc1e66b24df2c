"""Conversion between Keplerian elements of an elliptic orbit and position with velocity."""

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch, cross, dot, floating, resolution
from jaxatt.environment.orbit import MU_EARTH


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class KeplerianElements:
    """Classical orbital elements, each of shape (...), in SI units and radians.

    Attributes
    ----------
    semi_major_axis : (...) [m]
    eccentricity : (...)
        In [0, 1).
    inclination : (...) [rad]
        In [0, pi].
    raan : (...) [rad]
        Right ascension of the ascending node.
    argument_of_perigee : (...) [rad]
    true_anomaly : (...) [rad]
    """

    semi_major_axis: jax.Array
    eccentricity: jax.Array
    inclination: jax.Array
    raan: jax.Array
    argument_of_perigee: jax.Array
    true_anomaly: jax.Array


def to_state(elements: KeplerianElements, mu: ArrayLike = MU_EARTH) -> tuple[jax.Array, jax.Array]:
    """Inertial position and velocity of Keplerian elements.

    Parameters
    ----------
    elements : KeplerianElements of (...)
        The fields broadcast against each other.
    mu : (...) [m^3/s^2]

    Returns
    -------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
    """
    a, e, inclination, raan, perigee, anomaly, mu = broadcast_batch(
        *(
            floating(field)[..., None]
            for field in (
                elements.semi_major_axis,
                elements.eccentricity,
                elements.inclination,
                elements.raan,
                elements.argument_of_perigee,
                elements.true_anomaly,
                mu,
            )
        )
    )
    node, across = _node_axes(raan, jnp.cos(inclination), jnp.sin(inclination))
    latitude = perigee + anomaly
    parameter = a * (1 - e * e)
    radius = parameter / (1 + e * jnp.cos(anomaly))
    r_i = radius * (jnp.cos(latitude) * node + jnp.sin(latitude) * across)
    v_i = jnp.sqrt(mu / parameter) * (
        (jnp.cos(latitude) + e * jnp.cos(perigee)) * across
        - (jnp.sin(latitude) + e * jnp.sin(perigee)) * node
    )
    return r_i, v_i


def from_state(r_i: ArrayLike, v_i: ArrayLike, mu: ArrayLike = MU_EARTH) -> KeplerianElements:
    """Keplerian elements of an inertial position and velocity on an elliptic orbit.

    Where an element is undefined it is set to zero and the next takes its part: an equatorial
    orbit has raan = 0, a circular one argument_of_perigee = 0. Close to these the single angles
    are ill determined, but the elements together still give the state back to rounding.

    Parameters
    ----------
    r_i : (..., 3) [m]
    v_i : (..., 3) [m/s]
    mu : (...) [m^3/s^2]

    Returns
    -------
    KeplerianElements of (...)
        raan, argument_of_perigee and true_anomaly in [0, 2 pi].
    """
    r_i, v_i, mu = broadcast_batch(r_i, v_i, floating(mu)[..., None])
    radius = jnp.sqrt(dot(r_i, r_i))[..., None]
    momentum = cross(r_i, v_i)
    normal = momentum / jnp.sqrt(dot(momentum, momentum))[..., None]
    vanishing = (10 * resolution(r_i)) ** 2

    n_x, n_y, n_z = normal[..., :1], normal[..., 1:2], normal[..., 2:]
    equatorial = n_x**2 + n_y**2 < vanishing
    raan = jnp.arctan2(jnp.where(equatorial, 0.0, n_x), jnp.where(equatorial, 1.0, -n_y))
    # Negative only by rounding, where raan was set to zero.
    sin_inclination = jnp.abs(n_x * jnp.sin(raan) - n_y * jnp.cos(raan))
    node, across = _node_axes(raan, n_z, sin_inclination)

    e_vector = cross(v_i, momentum) / mu - r_i / radius
    e_node, e_across = dot(e_vector, node)[..., None], dot(e_vector, across)[..., None]
    circular = e_node**2 + e_across**2 < vanishing
    perigee = jnp.arctan2(jnp.where(circular, 0.0, e_across), jnp.where(circular, 1.0, e_node))
    # Projections rather than norms: their gradients exist on circular and equatorial orbits.
    eccentricity = jnp.abs(e_node * jnp.cos(perigee) + e_across * jnp.sin(perigee))
    latitude = jnp.arctan2(dot(r_i, across), dot(r_i, node))[..., None]
    full = 2 * math.pi
    return KeplerianElements(
        semi_major_axis=(1 / (2 / radius - dot(v_i, v_i)[..., None] / mu))[..., 0],
        eccentricity=eccentricity[..., 0],
        inclination=jnp.arctan2(sin_inclination, n_z)[..., 0],
        raan=jnp.mod(raan, full)[..., 0],
        argument_of_perigee=jnp.mod(perigee, full)[..., 0],
        true_anomaly=jnp.mod(latitude - perigee, full)[..., 0],
    )


def _node_axes(
    raan: jax.Array, cos_inclination: jax.Array, sin_inclination: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Unit vectors (..., 3) in the orbit plane: to the ascending node, and 90 degrees ahead."""
    sin, cos = jnp.sin(raan), jnp.cos(raan)
    node = jnp.concatenate([cos, sin, jnp.zeros_like(cos)], axis=-1)
    across = jnp.concatenate(
        [-sin * cos_inclination, cos * cos_inclination, sin_inclination], axis=-1
    )
    return node, across
