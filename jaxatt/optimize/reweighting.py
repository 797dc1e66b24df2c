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

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

Response = Callable[[Array], tuple[Array, Array]]
"""u (S, N, b) -> rows (S, m) and their derivatives (S, m, N, b), exact or nearly so."""

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
    """Where S starts ended.

    u : (S, N, b).  support : (S, N, b), 1 where control was allowed in the end.
    residual : (S,) largest absolute hard row at the point before the last step.
    saturated : (S,) whether a limit bound in the last step.
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


def _solve_spd(matrix: Array, rhs: Array) -> Array:
    """Solve an (m, m) positive definite system by Gauss-Jordan steps on whole arrays.

    Under `vmap` every step is one elementwise operation over the batch, which for a handful of
    rows is much faster than a LAPACK call for each member of it.
    """
    table = jnp.concatenate([matrix, rhs[:, None]], axis=1)

    def eliminate(k: Array, rows: Array) -> Array:
        pivot = lax.dynamic_index_in_dim(rows, k, keepdims=False)
        pivot = pivot / lax.dynamic_index_in_dim(pivot, k, keepdims=False)
        column = lax.dynamic_index_in_dim(rows, k, axis=1, keepdims=False)
        here = (jnp.arange(rows.shape[0]) == k)[:, None]
        return jnp.where(here, pivot[None], rows - column[:, None] * pivot[None])

    return lax.fori_loop(0, matrix.shape[0], eliminate, table)[:, -1]


def solve_small(matrix: Array, rhs: Array) -> Array:
    """Solve (S, m, m) positive definite systems for (S, m), the batch axis last on the way."""
    solve = jax.vmap(_solve_spd, in_axes=-1, out_axes=-1)
    return solve(jnp.moveaxis(matrix, 0, -1), rhs.T).T


def sparsify(
    response: Response,
    limits: Array,
    u: Array,
    free: Array,
    importance: Array,
    row_weight: Array,
    shared: bool,
    settings: Reweighting,
) -> SparseRoot:
    """Controls with few active entries that bring the rows to zero, from S starts.

    All starts take the same number of steps, so the batch is written out rather than left to
    `vmap`: the roll-outs want their batch axis last, the small systems want it first.

    limits : (n, b), rows l with |l u[k]| <= 1 for every stage k.
    u : (S, N, b); its pattern is what makes one start differ from another: the first weights come
        from it, but the first step begins at rest.  Where the support is given, the first controls.
    free : (S, N, b), 1 where control is allowed.  importance : (N,), cost of an active stage.
    row_weight : (S, m), inf for rows that must vanish; w for rows that cost w/2 row^2.
    shared : whether a stage's controls count as one.

    Nothing raises inside; a start that does not succeed shows in its residual.
    """
    hard = jnp.isinf(row_weight)

    def body(i: Array, point: _Point) -> _Point:
        deciding = i < settings.deciding
        smoothing = settings.smoothing * settings.factor**i
        squared = jnp.where(i == 0, u, point.u) ** 2
        if shared:
            squared = jnp.broadcast_to(jnp.sum(squared, axis=-1, keepdims=True), u.shape)
        freezing = (i == settings.deciding) & (i > 0)
        support = point.support * ((squared > SUPPORT_THRESHOLD**2) | ~freezing)
        count = (squared + smoothing**2) * (0.5 * jnp.log1p(1.0 / smoothing**2))
        effort = jnp.sqrt(point.u**2 + settings.settled_smoothing**2)
        weights = support * jnp.where(deciding, count / importance[None, :, None], effort)

        rows, jacobian = response(point.u * support)
        loose = jnp.where(point.held[..., None], 0.0, support)
        reached = jnp.einsum("sikc,skc->si", jacobian, point.u * loose)
        matrix = jnp.einsum("sikc,sjkc->sij", jacobian * (weights * loose)[:, None], jacobian)
        diagonal = jnp.diagonal(matrix, axis1=1, axis2=2)
        slack = jnp.where(hard, _DAMPING * diagonal, 1.0 / row_weight) + _NOTHING
        matrix = matrix + slack[:, :, None] * jnp.eye(rows.shape[1], dtype=u.dtype)[None]
        fresh = weights * jnp.einsum("sikc,si->skc", jacobian, solve_small(matrix, reached - rows))
        over = jnp.max(jnp.abs(jnp.einsum("skc,nc->skn", fresh, limits)), axis=-1)
        return _Point(
            fresh / jnp.maximum(1.0, over)[..., None],
            support,
            over > 1.0,
            jnp.max(jnp.where(hard, jnp.abs(rows), 0.0), axis=1),
        )

    start = _Point(
        jnp.where(settings.deciding > 0, 0.0, u * free),
        free,
        jnp.zeros(u.shape[:2], bool),
        jnp.full(u.shape[:1], jnp.inf, u.dtype),
    )
    end = lax.fori_loop(0, settings.deciding + settings.settling, body, start)
    return SparseRoot(end.u, end.support, end.residual, jnp.any(end.held, axis=1))
