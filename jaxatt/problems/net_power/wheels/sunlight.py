"""Collecting area of flat panels to second order in a small turn of the body.

The area is that of (4.4) and (5.4), each max(c, 0) by (2.11): smooth, with closed-form slopes.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.simulation.momentum_model import Components, cross
from jaxatt.spacecraft.panels import SolarPanels

_TINY = 1e-30


class Collected(NamedTuple):
    """Collecting area () [m^2], and its derivatives by the sun's direction in body axes.

    slope : three scalars.  bend : six, the upper triangle row by row.
    """

    area: Array
    slope: Components
    bend: Components


PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def collected(panels: SolarPanels, sun: Components, smoothing: Array) -> Collected:
    """Evaluate the area and its derivatives.

    sun : unit vector in body axes, three scalars.  smoothing : () alpha of (2.11).
    """
    normals = jnp.asarray(panels.normals)
    weight = jnp.asarray(panels.area) * jnp.asarray(panels.efficiency)
    count = normals.shape[1]
    cosine = jnp.stack(
        [sum((normals[i, j] * sun[i] for i in range(3)), 0.0 * sun[0]) for j in range(count)]
    )
    squared = cosine * cosine
    root = jnp.sqrt(squared + jnp.maximum(smoothing, _TINY))
    positive = 0.5 * (cosine + root)
    step = 0.5 * (1.0 + cosine / root)
    corner = 0.5 * jnp.maximum(smoothing, _TINY) / (root * root * root)
    if panels.incidence_exponent == 2:
        value, first = positive * cosine, step * cosine + positive
        second = corner * cosine + 2.0 * step
    else:
        value, first, second = positive, step, corner
    value, first, second = weight * value, weight * first, weight * second
    shades = jnp.asarray(panels.shades)
    # Deployed faces shade all others: (1 - sum of their positive parts).
    own, other = shades, 1.0 - shades
    lit = 1.0 - jnp.sum(own * positive)
    shaded = jnp.sum(other * value)
    by_cosine = (own + other * lit) * first - own * step * shaded
    area = jnp.sum(own * value) + lit * shaded
    bent = (own + other * lit) * second - own * corner * shaded
    slope = tuple(jnp.sum(normals[i] * by_cosine) for i in range(3))
    shade = [jnp.sum(normals[i] * own * step) for i in range(3)]
    gain = [jnp.sum(normals[i] * other * first) for i in range(3)]
    bend = tuple(
        jnp.sum(normals[i] * normals[j] * bent) - shade[i] * gain[j] - shade[j] * gain[i]
        for i, j in PAIRS
    )
    return Collected(area, slope, bend)


def by_turn(found: Collected, sun: Components) -> tuple[Components, dict[tuple[int, int], Array]]:
    """Slope (3,) and upper triangle of the Hessian of the area in a small turn of the body.

    The sun, seen from a body that turned by phi, is at s + s x phi + (phi x (phi x s)) / 2.
    """
    slope, bend = found.slope, found.bend
    gradient = cross(slope, sun)
    full = {pair: bend[k] for k, pair in enumerate(PAIRS)}
    full |= {(j, i): bend[k] for k, (i, j) in enumerate(PAIRS)}
    # Rows of B S, with S phi = s x phi, then S' (B S).
    rows = [cross((full[i, 0], full[i, 1], full[i, 2]), sun) for i in range(3)]
    columns = [cross((rows[0][j], rows[1][j], rows[2][j]), sun) for j in range(3)]
    along = slope[0] * sun[0] + slope[1] * sun[1] + slope[2] * sun[2]
    hessian = {}
    for i, j in PAIRS:
        entry = columns[j][i] + 0.5 * (slope[i] * sun[j] + sun[i] * slope[j])
        hessian[i, j] = entry - along if i == j else entry
    return gradient, hessian
