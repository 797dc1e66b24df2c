"""Trial points of one iteration, from second-order or first-order information."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

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
    reach = jnp.max(jnp.abs(x - box.project(x - gradient)), initial=0.0)
    width = jnp.minimum(1e-6, reach)
    below = (x - box.lower <= width) & (gradient > 0)
    above = (box.upper - x <= width) & (gradient < 0)
    return below | above | (box.lower >= box.upper)


def _at_bounds(x: Array, gradient: Array, fixed: Array, box: Box) -> Array:
    """Put the held variables onto their bounds."""
    edge = jnp.where(gradient > 0, box.lower, box.upper)
    edge = jnp.where(jnp.isfinite(edge), edge, x)
    return jnp.where(fixed, edge, x)


def descent(x: Array, gradient: Array, radius: Array, box: Box) -> Array:
    """Trial points (5, n) along the projected gradient."""
    size = jnp.linalg.norm(gradient) + 1e-300
    shares = jnp.asarray(_SLOPES, x.dtype)
    return jax.vmap(lambda share: box.project(x - share * radius * gradient / size))(shares)


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
    free = jnp.where(fixed, 0.0, gradient)
    base = _at_bounds(x, gradient, fixed, box)
    within = steps(free, spectrum, radius * jnp.asarray(_RADII, x.dtype))
    way = spectrum.vectors[:, 0]
    reach = radius * jnp.asarray(_CURVED, x.dtype)
    moves = jnp.concatenate([within, reach[:, None] * way[None, :], -reach[:, None] * way[None, :]])
    trials = jax.vmap(lambda move: box.project(base + jnp.where(fixed, 0.0, move)))(moves)
    shares = jnp.asarray(_SHARES, x.dtype)
    towards = jax.vmap(lambda share: box.project(x + share * (newton - x)))(shares)
    return jnp.concatenate(
        [trials, towards, descent(x, gradient, radius, box), _probes(x, fixed, radius, box)]
    )


def _probes(x: Array, fixed: Array, radius: Array, box: Box) -> Array:
    """Fixed pattern of points around x, (PROBES, n)."""
    ways = np.random.default_rng(0).normal(size=(PROBES // 4, x.shape[0]))
    ways = np.concatenate([ways, -ways]) / np.linalg.norm(ways, axis=1).max()
    moves = jnp.asarray(np.concatenate([ways, 0.1 * ways]), x.dtype)
    reach = jnp.maximum(0.1, radius)
    return jax.vmap(lambda move: box.project(x + reach * jnp.where(fixed, 0.0, move)))(moves)


def along(
    x: Array, gradient: Array, direction: Array, fixed: Array, radius: Array, box: Box
) -> Array:
    """Trial points at fractions of a direction, projected, and along the gradient."""
    base = _at_bounds(x, gradient, fixed, box)
    move = jnp.where(fixed, 0.0, direction)
    shares = jnp.asarray(_ARC, x.dtype)
    arc = jax.vmap(lambda share: box.project(base + share * move))(shares)
    return jnp.concatenate([arc, descent(x, gradient, radius, box)])
