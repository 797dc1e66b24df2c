"""Smooth measures of the number of active intervals and of the L1 effort.

The maximum hands-off objective counts active intervals.  While the support is being decided the
count is replaced by a normalised logarithm, whose majorising curvature 2 w/(|u|^2 + s^2) turns a
Newton step into iterative reweighting; once the support is frozen the L1 effort is minimised on
it.  The relaxed complementarity vector of the source needs no variables of its own: for a given
torque its best value is known in closed form (`complementarity_vector`).

Sources: Schaanning (2021), eqs. (3.32), (5.3), (5.5), (5.7); Candes, Wakin and Boyd (2008),
"Enhancing sparsity by reweighted l1 minimization".
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

_MAJORISER_SHARE = 0.2


def _squared_groups(u: Array, shared: bool) -> Array:
    squared = u**2
    return jnp.sum(squared, axis=-1, keepdims=True) if shared else squared


def log_count(u: Array, weight: Array, smoothing: Array, shared: bool) -> Array:
    """Normalised logarithmic count, about `weight` for every group with |u| near one.

    u : (N, b), scaled controls.  weight : (N,).  smoothing : ().
    shared : whether the b controls of an interval form one group (design 1) or one each.
    """
    s2 = smoothing**2
    groups = jnp.log1p(_squared_groups(u, shared) / s2) / jnp.log1p(1.0 / s2)
    return jnp.sum(weight[:, None] * groups)


def log_count_curvature(u: Array, weight: Array, smoothing: Array, shared: bool) -> Array:
    """Diagonal (N, b) of the quadratic that majorises `log_count` at u."""
    s2 = smoothing**2
    curvature = 2.0 * weight[:, None] / (_squared_groups(u, shared) + s2) / jnp.log1p(1.0 / s2)
    return jnp.broadcast_to(curvature, u.shape)


def absolute_effort(u: Array, smoothing: Array) -> Array:
    """Smoothed sum of |u| over all entries."""
    return jnp.sum(jnp.sqrt(u**2 + smoothing**2) - smoothing)


def absolute_effort_curvature(u: Array, smoothing: Array) -> Array:
    """Diagonal curvature of `absolute_effort`: its Hessian, bounded below.

    The quadratic that majorises the function alone converges linearly; the Hessian alone vanishes
    away from zero and overshoots.
    """
    squared = u**2 + smoothing**2
    majoriser = 1.0 / jnp.sqrt(squared)
    return jnp.maximum(smoothing**2 * majoriser**3, _MAJORISER_SHARE * majoriser)


def complementarity_vector(
    torque: npt.ArrayLike, epsilon: float, shared: bool = True
) -> npt.NDArray[np.float64]:
    """Largest xi in [0, 1] with |xi torque| <= epsilon: the optimum of (5.3).

    torque : (..., N, b) [N m].  epsilon : [N m].
    Returns (..., N) for shared complementarity (design 1), (..., N, b) otherwise (5.14).
    """
    size = np.abs(np.asarray(torque, float))
    if shared:
        size = size.max(axis=-1)
    return np.minimum(1.0, epsilon / np.maximum(size, epsilon))
