"""Exact trust-region steps for several radii at once.

With the eigenvalues known, every further radius costs n operations, so that the radius need not
be guessed: the caller tries them all and keeps the best.
"""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense import arrays
from jaxatt.optimize.dense.arrays import namespace

_CORRECTIONS = 8
_SETTLED = 1e-8
_SMALLEST_SHIFT = 1e-16


class Spectrum(NamedTuple):
    """Eigenvalues (n,), ascending, and eigenvectors in the columns of (n, n)."""

    values: Array
    vectors: Array


def spectrum_of(hessian: Array, free: Array) -> Spectrum:
    """Eigenvalues of a symmetric matrix on the free variables, (n,) bool; held ones come last."""
    xp = namespace(hessian)
    coupled = free[:, None] & free[None, :]
    finite = xp.where(coupled & xp.isfinite(hessian), hessian, 0.0)
    above = 2.0 * xp.max(xp.sum(abs(finite), axis=1)) + 1.0
    held = xp.where(free, 0.0, above)
    values, vectors = arrays.eigh(0.5 * (finite + finite.T) + xp.diag(held))
    return Spectrum(values, vectors)


def steps(gradient: Array, spectrum: Spectrum, radii: Array) -> Array:
    """Minimisers of the quadratic model within each radius, (k, n).

    gradient : (n,), zero where a variable is held.  radii : (k,).
    Where the gradient has next to no part along the direction of the most negative curvature it
    is given one, so that saddles are left (the hard case: Nocedal & Wright, section 4.3).
    """
    xp = namespace(gradient)
    values, vectors = spectrum
    parts = vectors.T @ gradient
    lowest = xp.maximum(0.0, -values[0])
    least = 1e-3 * lowest * radii
    lead = xp.where(parts[0] < 0, -1.0, 1.0) * xp.maximum(abs(parts[0]), least)
    others = xp.broadcast_to(parts[1:], (radii.shape[0], parts.shape[0] - 1))
    nudged = xp.concatenate([lead[:, None], others], axis=1)
    above = (values + lowest)[None, :]

    def step(shift: Array) -> tuple[Array, Array, Array]:
        """Step along the eigenvectors, its length, and the length's fall with the shift."""
        curvature = xp.maximum(above + shift[:, None], 1e-300)
        step = -nudged / curvature
        square = step**2
        length = xp.sqrt(xp.sum(square, axis=1))
        return step, length, xp.sum(square / curvature, axis=1) / (length + 1e-300)

    smallest = _SMALLEST_SHIFT * (xp.sqrt(parts @ parts) + least) / radii + 1e-300

    def correct(shift: Array) -> Array:
        """Newton's method on 1 / length, which is concave: from below it never goes too far."""
        _, length, fall = step(shift)
        change = (length / radii - 1.0) * length / (fall + 1e-300)
        return xp.maximum(shift + change, smallest)

    def settled(old: Array, new: Array) -> Array:
        return xp.all(abs(new - old) <= _SETTLED * new)

    # No part of the step may be longer than the whole.
    shift = xp.maximum(xp.max(abs(nudged) / radii[:, None] - above, axis=1), smallest)
    shift = arrays.repeat(_CORRECTIONS, correct, shift, settled)
    interior = (values[0] > 0) & (step(0.0 * radii)[1] <= radii)
    return step(xp.where(interior, 0.0, shift))[0] @ vectors.T
