"""Trial points of one iteration, from second-order or first-order information."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.arrays import namespace
from jaxatt.optimize.dense.residuals import Box
from jaxatt.optimize.dense.trust_region import Spectrum, steps

_RADII = (4.0, 2.0, 1.0, 0.5, 0.25, 0.06, 0.015, 1e-3, 1e-5, 1e-7)
_CURVED = (4.0, 1.0, 0.25, 0.06, 1e-3)
_SLOPES = (1.0, 0.1, 1e-2, 1e-4, 1e-7)
_SHARES = (1.0, 0.5, 0.25, 0.06, 0.01)
PROBES = 24
_ARC = (4.0, 1.0, 0.5, 0.25, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6)


def held(x: Array, gradient: Array, box: Box) -> Array:
    """Variables (n,) bool at a bound that the descent direction would violate.

    Near counts as at, the nearer to a minimum the less: Bertsekas (1982), Projected Newton methods.
    """
    xp = namespace(x)
    reach = xp.max(abs(x - box.project(x - gradient)), initial=0.0)
    width = xp.minimum(1e-6, reach)
    below = (x - box.lower <= width) & (gradient > 0)
    above = (box.upper - x <= width) & (gradient < 0)
    return below | above | (box.lower >= box.upper)


def _at_bounds(x: Array, gradient: Array, fixed: Array, box: Box) -> Array:
    """Put the held variables onto their bounds."""
    xp = namespace(x)
    edge = xp.where(gradient > 0, box.lower, box.upper)
    edge = xp.where(xp.isfinite(edge), edge, x)
    return xp.where(fixed, edge, x)


def descent(x: Array, gradient: Array, radius: Array, box: Box) -> Array:
    """Trial points (5, n) along the projected gradient."""
    xp = namespace(x)
    way = radius * gradient / (xp.sqrt(gradient @ gradient) + 1e-300)
    return box.project(x[None, :] - xp.asarray(_SLOPES)[:, None] * way[None, :])


def second_order(
    x: Array,
    gradient: Array,
    spectrum: Spectrum,
    fixed: Array,
    newton: Array,
    radius: Array,
    box: Box,
) -> Array:
    """Trial points: trust-region and Newton steps, lowest curvature both ways, gradient."""
    xp = namespace(x)
    base = _at_bounds(x, gradient, fixed, box)
    within = steps(xp.where(fixed, 0.0, gradient), spectrum, radius * xp.asarray(_RADII))
    curved = radius * xp.asarray(_CURVED)[:, None] * spectrum.vectors[:, 0][None, :]
    moves = xp.where(fixed[None, :], 0.0, xp.concatenate([within, curved, -curved]))
    towards = x[None, :] + xp.asarray(_SHARES)[:, None] * (newton - x)[None, :]
    points = box.project(xp.concatenate([base[None, :] + moves, towards]))
    return xp.concatenate(
        [points, descent(x, gradient, radius, box), _probes(x, fixed, radius, box)]
    )


def _probes(x: Array, fixed: Array, radius: Array, box: Box) -> Array:
    """Fixed pattern of points around x, (PROBES, n)."""
    xp = namespace(x)
    moves = xp.where(fixed[None, :], 0.0, xp.asarray(_pattern(x.shape[0])))
    return box.project(x[None, :] + xp.maximum(0.1, radius) * moves)


@functools.cache
def _pattern(n: int) -> npt.NDArray[np.float64]:
    """Directions of the probes and lengths, (PROBES, n)."""
    ways = np.random.default_rng(0).normal(size=(PROBES // 4, n))
    ways = np.concatenate([ways, -ways]) / np.linalg.norm(ways, axis=1).max()
    return np.concatenate([ways, 0.1 * ways])


def along(
    x: Array, gradient: Array, direction: Array, fixed: Array, radius: Array, box: Box
) -> Array:
    """Trial points at fractions of a direction, projected, and along the gradient."""
    xp = namespace(x)
    base = _at_bounds(x, gradient, fixed, box)
    move = xp.where(fixed, 0.0, direction)
    arc = box.project(base[None, :] + xp.asarray(_ARC)[:, None] * move[None, :])
    return xp.concatenate([arc, descent(x, gradient, radius, box)])
