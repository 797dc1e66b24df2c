"""The Earth's main magnetic field by IGRF-14, evaluated without a singularity at the poles.

The recursion runs in Cartesian coordinates (Cunningham), so that the poles are points like any
others; the coefficients are packaged data, see `data/README.md`.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from importlib import resources

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import lax

Float64 = npt.NDArray[np.float64]


REFERENCE_RADIUS = 6371200.0
"""Radius [m] to which the coefficients refer."""

FIRST_YEAR, LAST_YEAR = 1900.0, 2030.0
_DEGREE = 13


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class MagneticModel:
    """Spherical-harmonic coefficients [T] at one date, up to degree 13, not normalised.

    cosine, sine : (14, 14), index [degree, order].
    """

    cosine: jax.Array | Float64
    sine: jax.Array | Float64


@functools.cache
def _table() -> tuple[Float64, Float64, Float64]:
    """Read the epochs (E,) and the coefficients g and h of all epochs, (14, 14, E) [nT]."""
    path = resources.files("jaxatt.environment") / "data" / "igrf14.shc"
    lines = [x for x in path.read_text(encoding="ascii").splitlines() if not x.startswith("#")]
    years = np.array(lines[1].split(), float)
    g, h = np.zeros((2, _DEGREE + 1, _DEGREE + 1, len(years)))
    for line in lines[2:]:
        degree, order, *values = line.split()
        n, m = int(degree), int(order)
        (g if m >= 0 else h)[n, abs(m)] = np.array(values, float)
    return years, g, h


def at_year(year: float) -> MagneticModel:
    """Coefficients at a decimal year, interpolated linearly between epochs five years apart.

    Raises `ValueError` where the model has no coefficients.
    """
    if not FIRST_YEAR <= year <= LAST_YEAR:
        raise ValueError(
            f"epoch: the year {year:.2f} is outside IGRF-14, which covers {FIRST_YEAR:.0f} to "
            f"{LAST_YEAR:.0f}; give a date within, or leave the magnetic torques out",
        )
    years, g, h = _table()
    last = int(np.clip(np.searchsorted(years, year, side="right"), 1, len(years) - 1))
    weight = (year - years[last - 1]) / (years[last] - years[last - 1])
    scale = 1e-9 * _schmidt_factors()

    def between(table: Float64) -> Float64:
        value: Float64 = (1.0 - weight) * table[..., last - 1] + weight * table[..., last]
        return value * scale

    return MagneticModel(between(g), between(h))


def _schmidt_factors() -> Float64:
    """Factors from Schmidt semi-normalised to plain Legendre functions, (14, 14)."""
    factors = np.zeros((_DEGREE + 1, _DEGREE + 1))
    for n in range(_DEGREE + 1):
        for m in range(n + 1):
            ratio = math.factorial(n - m) / math.factorial(n + m)
            factors[n, m] = math.sqrt(ratio * (1.0 if m == 0 else 2.0))
    return factors


def _harmonics(position: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Solid harmonics V, W (15, 15, ...) up to degree 14; index [degree, order]."""
    scaled = position / REFERENCE_RADIUS
    squared = jnp.sum(scaled**2, axis=-1)
    x, y, z = (scaled[None, ..., i] / squared[None] for i in range(3))
    rho = 1.0 / squared[None]
    size = _DEGREE + 2
    orders = np.arange(size).reshape(-1, *([1] * squared.ndim))
    first = jnp.where(orders == 0, jnp.sqrt(rho), 0.0 * rho)
    nothing = jnp.zeros_like(first)

    def degree(
        carry: tuple[jax.Array, jax.Array, jax.Array, jax.Array], n: jax.Array
    ) -> tuple[tuple[jax.Array, jax.Array, jax.Array, jax.Array], tuple[jax.Array, jax.Array]]:
        v1, w1, v2, w2 = carry

        def next_one(one: jax.Array, two: jax.Array, diagonal: jax.Array) -> jax.Array:
            gap = jnp.maximum(n - orders, 1)
            below = ((2 * n - 1) * z * one - (n + orders - 1) * rho * two) / gap
            shifted = jnp.concatenate([jnp.zeros_like(diagonal[:1]), diagonal[:-1]])
            return jnp.where(orders < n, below, jnp.where(orders == n, (2 * n - 1) * shifted, 0.0))

        v = next_one(v1, v2, x * v1 - y * w1)
        w = next_one(w1, w2, x * w1 + y * v1)
        return (v, w, v1, w1), (v, w)

    _, (v, w) = lax.scan(degree, (first, nothing, nothing, nothing), jnp.arange(1, size))
    return jnp.concatenate([first[None], v]), jnp.concatenate([nothing[None], w])


def field(model: MagneticModel, position: jax.Array) -> jax.Array:
    """Magnetic flux density (..., 3) [T] in Earth-fixed axes.

    position : (..., 3) [m], geocentric, in Earth-fixed axes; outside the core.
    Source: the recursions of Montenbruck and Gill (2000), section 3.2.4, for the potential of the
    field instead of gravity's.
    """
    v, w = _harmonics(jnp.asarray(position))
    c, s = jnp.asarray(model.cosine)[1:], jnp.asarray(model.sine)[1:]
    n = np.arange(1, _DEGREE + 1)[:, None]
    m = np.arange(_DEGREE + 1)[None, :]
    v_up, w_up = v[2:, 1:], w[2:, 1:]  # degree n + 1, order m + 1
    v_same, w_same = v[2:, :-1], w[2:, :-1]
    v_down = jnp.concatenate([jnp.zeros_like(v_same[:, :1]), v_same[:, :-1]], axis=1)
    w_down = jnp.concatenate([jnp.zeros_like(w_same[:, :1]), w_same[:, :-1]], axis=1)
    zonal = np.where(m == 0, 1.0, 0.5)
    lower = np.where(m == 0, 0.0, 0.5 * (n - m + 2) * (n - m + 1))

    def total(weight: jax.Array | Float64, term: jax.Array) -> jax.Array:
        return jnp.tensordot(weight, term, axes=[(0, 1), (0, 1)])

    x = total(-zonal * c, v_up) + total(-zonal * s, w_up)
    x += total(lower * c, v_down) + total(lower * s, w_down)
    y = total(-zonal * c, w_up) + total(zonal * s, v_up)
    y += total(-lower * c, w_down) + total(lower * s, v_down)
    height = np.maximum(n - m + 1, 0)
    z = total(-height * c, v_same) + total(-height * s, w_same)
    return -jnp.stack([x, y, z], axis=-1)
