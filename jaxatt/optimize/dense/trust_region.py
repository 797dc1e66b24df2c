"""Exact trust-region steps for several radii at once.

With the eigenvalues known, every further radius costs n operations, so that the radius need not
be guessed: the caller tries them all and keeps the best.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

_BISECTIONS = 30
_SMALLEST_SHIFT = 1e-16


class Spectrum(NamedTuple):
    """Eigenvalues (n,), ascending, and eigenvectors in the columns of (n, n)."""

    values: Array
    vectors: Array


def spectrum_of(hessian: Array, free: Array) -> Spectrum:
    """Eigenvalues of a symmetric matrix on the free variables, (n,) bool; held ones come last."""
    coupled = free[:, None] & free[None, :]
    finite = jnp.nan_to_num(jnp.where(coupled, hessian, 0.0), posinf=0.0, neginf=0.0)
    above = 2.0 * jnp.max(jnp.sum(jnp.abs(finite), axis=1)) + 1.0
    held = jnp.where(free, 0.0, above)
    values, vectors = jnp.linalg.eigh(0.5 * (finite + finite.T) + jnp.diag(held))
    return Spectrum(values, vectors)


def steps(gradient: Array, spectrum: Spectrum, radii: Array) -> Array:
    """Minimisers of the quadratic model within each radius, (k, n).

    gradient : (n,), zero where a variable is held.  radii : (k,).
    Where the gradient has next to no part along the direction of the most negative curvature it
    is given one, so that saddles are left (the hard case: Nocedal & Wright, section 4.3).
    """
    values, vectors = spectrum
    parts = vectors.T @ gradient
    lowest = jnp.maximum(0.0, -values[0])
    size = jnp.linalg.norm(parts)

    def one(radius: Array) -> Array:
        least = 1e-3 * lowest * radius
        sign = jnp.where(parts[0] < 0, -1.0, 1.0)
        nudged = parts.at[0].set(sign * jnp.maximum(jnp.abs(parts[0]), least))
        highest = (size + least) / radius + 1e-300

        def length(shift: Array) -> Array:
            return jnp.linalg.norm(step(shift))

        def step(shift: Array) -> Array:
            return -nudged / jnp.maximum(values + lowest + shift, 1e-300)

        def halve(_: int, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
            low, high = bracket
            middle = jnp.sqrt(low * high)
            inside = length(middle) <= radius
            return jnp.where(inside, low, middle), jnp.where(inside, middle, high)

        low = highest * _SMALLEST_SHIFT
        _, high = lax.fori_loop(0, _BISECTIONS, halve, (low, highest))
        interior = (values[0] > 0) & (length(jnp.zeros_like(low)) <= radius)
        return vectors @ step(jnp.where(interior, 0.0, high))

    return jax.vmap(one)(radii)
