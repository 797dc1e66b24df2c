"""Sparse root finding: few active controls that bring some rows to zero.

Newton steps of least weighted norm, min sum |v|^2 / d subject to J (v - u) = -r, whose weights d
come from the last iterate: large where it is large.  With d = |u|^2 + s^2 and s shrinking, that is
iterative reweighting for the log-sum measure of sparsity, and the support decides itself.  Then the
support is frozen, and d = sqrt(u^2 + s^2) leads to the least sum of magnitudes on it.  Few rows
make each step a system of their own small size, whatever the number of controls.

Controls over their limit are put on it and kept there for the next step, which lets them go as soon
as it wants less of them; so saturation holds exactly at every iterate.  A stage on its limit has no
freedom to turn, so where nearly all stages saturate this can fail although there is an answer;
`SparseRoot.saturated` tells those starts apart.

Sources: Candes, Wakin and Boyd (2008), "Enhancing sparsity by reweighted l1 minimization";
Chartrand and Yin (2008), "Iteratively reweighted algorithms for compressive sensing".
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.reweighting.equations import Linearise
from jaxatt.optimize.small_systems import solve_spd

SUPPORT_THRESHOLD = 1e-3
"""Controls, in units of their scale, that count as active when the support is frozen."""

_DAMPING = 1e-12
_NOTHING = 1e-300


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Reweighting:
    """Settings; all are traced, so changing one does not recompile.

    deciding : steps in which the support decides itself; none if it is given.
    smoothing, factor : the first s of those and what it shrinks by in each.
    settling : steps on the frozen support.  settled_smoothing : their s.
    """

    deciding: int = 14
    smoothing: float = 0.1
    factor: float = 0.587
    settling: int = 2
    settled_smoothing: float = 1e-3


class SparseRoot(NamedTuple):
    """Where a start ended.

    u : (N, b).  support : (N, b), 1 where control was allowed in the end.
    residual : () largest absolute hard row at the point before the last step.
    saturated : () whether a limit bound in the last step.
    """

    u: Array
    support: Array
    residual: Array
    saturated: Array


class _Point(NamedTuple):
    u: Array
    support: Array
    held: Array
    residual: Array


def _total(values: Array) -> Array:
    """Sum over the columns of (N, b), elementwise: the batch axis stays where it is."""
    return functools.reduce(operator.add, (values[:, c] for c in range(values.shape[1])))


def sparsify(
    linearise: Linearise,
    limits: Array,
    u: Array,
    free: Array,
    importance: Array,
    row_weight: Array,
    shared: bool,
    settings: Reweighting,
) -> SparseRoot:
    """Controls with few active entries that bring the rows to zero, from one start.

    Under `jax.vmap` it is fastest with the batch axis last, where every entry is contiguous.

    limits : (n, b), rows l with |l u[k]| <= 1 for every stage k.
    u : (N, b); its pattern is what makes one start differ from another: the first weights come
        from it, but the first step begins at rest.  Where the support is given, the first controls.
    free : (N, b), 1 where control is allowed.  importance : (N,), cost of an active stage.
    row_weight : (m,), inf for rows that must vanish; w for rows that cost w/2 row^2.
    shared : whether a stage's controls count as one.

    Nothing raises inside; a start that does not succeed shows in its residual.
    """
    hard = jnp.isinf(row_weight)
    count, size = u.shape[0], row_weight.shape[0]

    def body(i: Array, point: _Point) -> _Point:
        deciding = i < settings.deciding
        smoothing = settings.smoothing * settings.factor**i
        squared = jnp.where(i == 0, u, point.u) ** 2
        if shared:
            squared = jnp.broadcast_to(_total(squared)[:, None], u.shape)
        freezing = (i == settings.deciding) & (i > 0)
        support = point.support * ((squared > SUPPORT_THRESHOLD**2) | ~freezing)
        counted = (squared + smoothing**2) * (0.5 * jnp.log1p(1.0 / smoothing**2))
        effort = jnp.sqrt(point.u**2 + settings.settled_smoothing**2)
        weights = support * jnp.where(deciding, counted / importance[:, None], effort)

        loose = jnp.where(point.held[:, None], 0.0, support)
        found = linearise(point.u * support, weights * loose, point.u * loose, ~deciding)
        diagonal = jnp.stack([found.matrix[k, k] for k in range(size)])
        slack = jnp.where(hard, _DAMPING * diagonal, 1.0 / row_weight) + _NOTHING
        matrix = found.matrix + slack[:, None] * jnp.eye(size, dtype=u.dtype)
        fresh = weights * found.pullback(solve_spd(matrix, found.reached - found.rows))
        relative = (jnp.abs(_total(fresh * row[None])) for row in limits)
        over = functools.reduce(jnp.maximum, relative)
        return _Point(
            fresh / jnp.maximum(1.0, over)[:, None],
            support,
            over > 1.0,
            jnp.max(jnp.where(hard, jnp.abs(found.rows), 0.0)),
        )

    start = _Point(
        jnp.where(settings.deciding > 0, 0.0, u * free),
        free,
        jnp.zeros(count, bool),
        jnp.asarray(jnp.inf, u.dtype),
    )
    end = lax.fori_loop(0, settings.deciding + settings.settling, body, start)
    return SparseRoot(end.u, end.support, end.residual, jnp.any(end.held))
