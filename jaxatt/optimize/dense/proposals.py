"""Trial points of one iteration, from second-order or first-order information."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.arrays import certain, namespace, no
from jaxatt.optimize.dense.constraints import Constraints
from jaxatt.optimize.dense.trust_region import Spectrum, steps

_RADII = np.array([4.0, 2.0, 1.0, 0.5, 0.25, 0.06, 0.015, 1e-3, 1e-5, 1e-7])
_CURVED = np.array([[4.0, 1.0, 0.25, 0.06, 1e-3], [-4.0, -1.0, -0.25, -0.06, -1e-3]]).reshape(-1, 1)
_SLOPES = -np.array([[1.0], [0.1], [1e-2], [1e-4], [1e-7]])
_SHARES = np.array([[1.0], [0.5], [0.25], [0.06], [0.01]])
_ARC = np.array([[4.0], [1.0], [0.5], [0.25], [0.1], [0.03], [0.01], [1e-3], [1e-4], [1e-6]])
BATCH = len(_RADII) + len(_CURVED) + len(_SHARES) + len(_SLOPES)
"""Trial points that are proposed in every iteration."""
NEWTON = len(_RADII) + len(_CURVED)
"""Index of the whole Newton step among them."""
_PROBES = 24


def held(x: Array, gradient: Array, constraints: Constraints) -> Array:
    """Variables (n,) bool at a bound that the descent direction would violate.

    Near counts as at, the nearer to a minimum the less: Bertsekas (1982), Projected Newton methods.
    """
    xp, box = namespace(x), constraints.box
    if constraints.unbounded:
        return constraints.pinned
    reach = xp.max(abs(x - box.project(x - gradient)), initial=0.0)
    width = xp.minimum(1e-6, reach)
    below = (x - box.lower <= width) & (gradient > 0)
    above = (box.upper - x <= width) & (gradient < 0)
    return below | above | constraints.pinned


def _freely(
    x: Array, gradient: Array, fixed: Array, moves: Array, constraints: Constraints
) -> Array:
    """Points at `moves` (k, n) from x, the variables that are held on their bounds."""
    xp, box = namespace(x), constraints.box
    if certain(no(xp.any(fixed))):
        return x[None, :] + moves
    edge = xp.where(gradient > 0, box.lower, box.upper)
    edge = xp.where(xp.isfinite(edge), edge, x)
    base = xp.where(fixed, edge, x)
    return base[None, :] + xp.where(fixed[None, :], 0.0, moves)


def _downhill(gradient: Array, radius: Array) -> Array:
    """Steps (5, n) along the gradient."""
    way = radius * gradient / (namespace(gradient).sqrt(gradient.dot(gradient)) + 1e-300)
    return _SLOPES * way[None, :]


def second_order(
    x: Array,
    gradient: Array,
    spectrum: Spectrum,
    fixed: Array,
    newton: Array,
    radius: Array,
    constraints: Constraints,
) -> Array:
    """Trial points: trust-region and Newton steps, lowest curvature both ways, gradient."""
    xp = namespace(x)
    within = steps(xp.where(fixed, 0.0, gradient), spectrum, radius * _RADII)
    curved = radius * _CURVED * spectrum.vectors[:, 0][None, :]
    free = _freely(x, gradient, fixed, xp.concatenate([within, curved]), constraints)
    towards = _SHARES * (newton - x)[None, :]
    others = x[None, :] + xp.concatenate([towards, _downhill(gradient, radius)])
    return constraints.project(xp.concatenate([free, others]))


def probes(x: Array, fixed: Array, radius: Array, constraints: Constraints) -> Array:
    """Fixed pattern of points around x, (24, n)."""
    xp = namespace(x)
    moves = xp.where(fixed[None, :], 0.0, _pattern(x.shape[0]))
    return constraints.project(x[None, :] + xp.maximum(0.1, radius) * moves)


@functools.cache
def _pattern(n: int) -> npt.NDArray[np.float64]:
    """Directions of the probes and lengths, (24, n)."""
    ways = np.random.default_rng(0).normal(size=(_PROBES // 4, n))
    ways = np.concatenate([ways, -ways]) / np.linalg.norm(ways, axis=1).max()
    return np.concatenate([ways, 0.1 * ways])


def along(
    x: Array,
    gradient: Array,
    direction: Array,
    fixed: Array,
    radius: Array,
    constraints: Constraints,
) -> Array:
    """Trial points at fractions of a direction, projected, and along the gradient."""
    arc = _freely(x, gradient, fixed, direction[None, :] * _ARC, constraints)
    down = x[None, :] + _downhill(gradient, radius)
    return constraints.project(namespace(x).concatenate([arc, down]))
