"""Nutation: how the Earth's axis nods about its mean direction, and the ecliptic's obliquity."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment.epoch import DAYS_PER_CENTURY


class Nutation(NamedTuple):
    """Nutation in longitude and in obliquity, each (...) [rad]."""

    longitude: jax.Array
    obliquity: jax.Array


_ARGUMENTS = np.array(
    [
        (485868.249036, 1717915923.2178),
        (1287104.79305, 129596581.0481),
        (335779.526232, 1739527262.8478),
        (1072260.70369, 1602961601.2090),
        (450160.398036, -6962890.5431),
    ]
)
"""[arcsec] At J2000 and in a century: mean anomalies of moon and sun, the moon's argument of
latitude, its elongation and its node."""

# Multiples of the arguments; amplitudes [arcsec] of the sine in longitude, the cosine in obliquity.
_TERMS = np.array(
    [
        (0, 0, 0, 0, 1, -17.2064161, 9.2052331),
        (0, 0, 2, -2, 2, -1.3170906, 0.5730336),
        (0, 0, 2, 0, 2, -0.2276413, 0.0978459),
        (0, 0, 0, 0, 2, 0.2074554, -0.0897492),
        (0, 1, 0, 0, 0, 0.1475877, 0.0073871),
        (0, 1, 2, -2, 2, -0.0516821, 0.0224386),
        (1, 0, 0, 0, 0, 0.0711159, -0.0006750),
        (0, 0, 2, 0, 1, -0.0387298, 0.0200728),
        (1, 0, 2, 0, 2, -0.0301461, 0.0129025),
        (0, -1, 2, -2, 2, 0.0215829, -0.0095929),
        (-1, 0, 0, 2, 0, 0.0156994, -0.0001235),
        (0, 0, 2, -2, 1, 0.0128227, -0.0068982),
        (-1, 0, 2, 0, 2, 0.0123457, -0.0053311),
        (0, 0, 0, 2, 0, 0.0063384, -0.0001220),
        (1, 0, 0, 0, 1, 0.0063110, -0.0033228),
        (-1, 0, 2, 2, 2, -0.0059641, 0.0025543),
        (-1, 0, 0, 0, 1, -0.0057976, 0.0031429),
        (1, 0, 2, 0, 1, -0.0051613, 0.0026366),
    ]
)
_IN_TIME = (-0.0174666, 0.0009086)
"""[arcsec] By which the amplitudes of the first term change in a century."""


def nutation(days: jax.Array) -> Nutation:
    """Nutation at a date by its largest terms, within 0.05 arcsec; days (...) since J2000.

    Source: IAU 2000A in the IERS conventions (2010), tables 5.3, its terms above 0.005 arcsec.
    """
    t = days / DAYS_PER_CENTURY
    arguments = [arcsec(at + rate * t) for at, rate in _ARGUMENTS.tolist()]

    def wave(multiples: jax.Array, sine: jax.Array, cosine: jax.Array) -> jax.Array:
        angle = sum((n * a for n, a in zip(multiples, arguments, strict=True)), jnp.zeros_like(t))
        return jnp.stack([sine * jnp.sin(angle), cosine * jnp.cos(angle)])

    terms = (jnp.asarray(part) for part in (_TERMS[:, :5], _TERMS[:, 5], _TERMS[:, 6]))
    waves = jax.vmap(wave)(*terms)
    along, across = jnp.sum(waves, axis=0)
    node = arguments[-1]
    return Nutation(
        arcsec(along + _IN_TIME[0] * t * jnp.sin(node)),
        arcsec(across + _IN_TIME[1] * t * jnp.cos(node)),
    )


def mean_obliquity(days: jax.Array) -> jax.Array:
    """Angle (...) [rad] between the ecliptic and the mean equator; days (...) since J2000.

    Source: Capitaine, Wallace and Chapront (2003), IAU 2006, eq. (39).
    """
    t = days / DAYS_PER_CENTURY
    return arcsec(84381.406 + t * (-46.836769 + t * (-0.0001831 + t * 0.00200340)))


def arcsec(value: jax.Array) -> jax.Array:
    """Angle [rad] from seconds of arc."""
    return jnp.deg2rad(value / 3600.0)
