"""Exact trust-region steps for several radii at once.

With the eigenvalues known, every further radius costs n operations, so that the radius need not
be guessed: the caller tries them all and keeps the best.
"""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense import arrays
from jaxatt.optimize.dense.arrays import certain, namespace, no

_CORRECTIONS = 8
_SETTLED = 1e-4
_SMALLEST_SHIFT = 1e-16


class Spectrum(NamedTuple):
    """Eigenvalues (n,), ascending, and eigenvectors in the columns of (n, n)."""

    values: Array
    vectors: Array


def spectrum_of(hessian: Array, fixed: Array) -> Spectrum:
    """Eigenvalues of a symmetric matrix on the variables that are not fixed, (n,) bool.

    Those of fixed variables come last.
    """
    xp = namespace(hessian)
    finite = xp.isfinite(hessian)
    if certain(no(xp.any(fixed)) & xp.all(finite)):
        return Spectrum(*arrays.eigh(hessian))
    free = no(fixed)
    coupled = free[:, None] & free[None, :]
    finite = xp.where(coupled & finite, hessian, 0.0)
    above = 2.0 * xp.max(xp.sum(abs(finite), axis=1)) + 1.0
    held = xp.where(free, 0.0, above)
    return Spectrum(*arrays.eigh(finite + xp.diag(held)))


def steps(gradient: Array, spectrum: Spectrum, radii: Array) -> Array:
    """Minimisers of the quadratic model within each radius, (k, n).

    gradient : (n,), zero where a variable is held.  radii : (k,).
    Where the gradient has next to no part along the direction of the most negative curvature it
    is given one, so that saddles are left (the hard case: Nocedal & Wright, section 4.3).
    """
    xp = namespace(gradient)
    values, vectors = spectrum
    parts = gradient.dot(vectors)
    lowest = xp.maximum(0.0, -values[0])
    least = 1e-3 * lowest * radii
    lead = xp.where(parts[0] < 0, -1.0, 1.0) * xp.maximum(abs(parts[0]), least)
    nudged = parts[None, :] + (lead - parts[0])[:, None] * xp.eye(1, parts.shape[0])
    above, ones = (values + lowest)[None, :], xp.ones(parts.shape[0])

    def step(shift: Array) -> tuple[Array, Array, Array, Array]:
        """Step along the eigenvectors, its square, its length, and the curvature."""
        curvature = xp.maximum(above + shift[:, None], 1e-300)
        step = nudged / curvature
        square = step * step
        return step, square, xp.sqrt(square.dot(ones)), curvature

    at_most, _, length, _ = step(0.0 * radii)
    interior = (values[0] > 0) & (length <= radii)
    if certain(xp.all(interior)):
        return -(at_most.dot(vectors.T))
    smallest = _SMALLEST_SHIFT * (xp.sqrt(parts.dot(parts)) + least) / radii + 1e-300

    def correct(shift: Array) -> Array:
        """Newton's method on 1 / length, which is concave: from below it never goes too far."""
        _, square, length, curvature = step(shift)
        fall = (square / curvature).dot(ones) / (length + 1e-300)
        change = (length / radii - 1.0) * length / (fall + 1e-300)
        return xp.maximum(shift + change, smallest)

    def settled(old: Array, new: Array) -> Array:
        return xp.all(new - old <= _SETTLED * new)

    # From below: no part of the step may be longer than the radius, nor the whole step if all
    # curvature were as large as the largest.
    parted = xp.max(abs(nudged) / radii[:, None] - above, axis=1)
    whole = xp.sqrt((nudged * nudged).dot(ones)) / radii - above[0, -1]
    shift = xp.maximum(xp.maximum(parted, whole), smallest)
    shift = arrays.repeat(_CORRECTIONS, correct, shift, settled)
    return -(step(xp.where(interior, 0.0, shift))[0].dot(vectors.T))
