"""Sparse root finding between bounds: few active controls, each within limits of its own.

As in `reweighting`, Newton steps of least weighted norm decide a support and settle on it; here
every step respects lower <= u <= upper exactly, which one-sided actuators need, where saturation is
the rule.  The step is the quadratic programme

    min  sum v^2 / (2 d)  +  sum w/2 (r + J (v - u))^2   subject to   lower <= v <= upper,

w infinite for hard rows.  Its dual has as many variables as there are rows, is concave and once
differentiable; a few damped Newton steps on it end at v = clip(d J'y, lower, upper).

Rows after those may be one-sided, path constraints that must not be negative: their dual variables
must not be either, and the Newton steps are projected (Bertsekas 1982).

Sources: Candes, Wakin and Boyd (2008) for the weights; Qi and Sun (1993) for Newton's method on
piecewise smooth equations; Bertsekas (1982), "Projected Newton methods for optimization problems
with simple constraints".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.reweighting.condensed import SUPPORT_THRESHOLD
from jaxatt.optimize.small_systems import solve_small

Response = Callable[[Array], tuple[Array, Array]]
"""u (S, N, b) -> rows (S, m) and their derivatives (S, m, N, b), exact or nearly so."""

_STEPS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
_DAMPING = 1e-9
_FAR = 1e-2
_HARD = 1e-13
_NOTHING = 1e-300


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class BoundedReweighting:
    """Settings; all are traced, so changing one does not recompile.

    deciding : steps in which the support decides itself; none if it is given.
    smoothing, factor : the first s of those and what it shrinks by in each.
    settling : steps on the frozen support.  settled_smoothing : their s.
    dual : Newton steps on the dual in each.
    reach : [rad] largest row that one step may take away, so that linearisations hold.
    effort : what a unit of effort costs while settling, in units of the soft rows' cost.
    """

    deciding: int = 14
    smoothing: float = 0.3
    factor: float = 0.6
    settling: int = 4
    settled_smoothing: float = 1e-3
    dual: int = 6
    reach: float = 1.0
    effort: float = 1.0


class BoundedRoot(NamedTuple):
    """Where S starts ended.

    u : (S, N, b).  support : (S, N, b), 1 where control was allowed in the end.
    residual : (S,) largest violation of a hard row at the point before the last step.
    moved : (S,) largest change of a control in the last step.
    """

    u: Array
    support: Array
    residual: Array
    moved: Array


class _Point(NamedTuple):
    u: Array
    support: Array
    dual: Array
    residual: Array
    moved: Array


def _clipped(d: Array, pull: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Minimiser of v^2/(2 d) - pull v between bounds, and the least value's negative."""
    v = jnp.clip(d * pull, lower, upper)
    return v, v * pull - v * v / (2.0 * d + _NOTHING)


def bounded_step(
    jacobian: Array,
    target: Array,
    d: Array,
    lower: Array,
    upper: Array,
    slack: Array,
    start: Array,
    steps: Array | int,
    one_sided: int = 0,
) -> tuple[Array, Array]:
    """Controls (S, M) of the quadratic programme and its dual variables (S, m), from `start`.

    jacobian : (S, m, M).  target : (S, m), what J v should be.  d, lower, upper : (S, M).
    slack : (S, m), 1/w.  one_sided : how many of the last rows J v may exceed their target.
    """
    sided = jnp.arange(target.shape[1])[None] >= target.shape[1] - one_sided

    def value(y: Array) -> Array:
        _, kept = _clipped(d, jnp.einsum("sim,si->sm", jacobian, y), lower, upper)
        return jnp.sum(kept, axis=-1) + jnp.sum(0.5 * slack * y**2 - target * y, axis=-1)

    def newton(_: Array, y: Array) -> Array:
        pull = jnp.einsum("sim,si->sm", jacobian, y)
        wanted = d * pull
        v = jnp.clip(wanted, lower, upper)
        inside = jnp.where((wanted >= lower) & (wanted <= upper), d, 0.0)
        gradient = jnp.einsum("sim,sm->si", jacobian, v) + slack * y - target
        loose = sided & (y <= 0.0) & (gradient >= 0.0)
        gradient = jnp.where(loose, 0.0, gradient)
        curvature = jnp.einsum("sim,sjm->sij", jacobian * inside[:, None], jacobian)
        whole = jnp.sum(jacobian**2 * d[:, None], axis=-1)
        missed = jnp.linalg.norm(gradient, axis=-1) / (jnp.linalg.norm(target, axis=-1) + _NOTHING)
        damping = slack + (_DAMPING + _FAR * jnp.minimum(1.0, missed))[:, None] * whole + _NOTHING
        eye = jnp.eye(y.shape[1], dtype=y.dtype)[None]
        matrix = curvature + damping[..., None] * eye
        apart = (loose[:, :, None] | loose[:, None, :]) & (eye == 0.0)
        step = solve_small(jnp.where(apart, 0.0, matrix), -gradient)
        tried = jnp.stack([y + s * step for s in _STEPS])
        tried = jnp.where(sided[None], jnp.maximum(0.0, tried), tried)
        best = jnp.argmin(jax.vmap(value)(tried), axis=0)
        return jnp.take_along_axis(tried, best[None, :, None], axis=0)[0]

    y = lax.fori_loop(0, steps, newton, start)
    return jnp.clip(d * jnp.einsum("sim,si->sm", jacobian, y), lower, upper), y


def sparsify_bounded(
    response: Response,
    lower: Array,
    upper: Array,
    u: Array,
    free: Array,
    importance: Array,
    row_weight: Array,
    settings: BoundedReweighting,
) -> BoundedRoot:
    """Controls with few active stages that bring the rows to zero, from S starts.

    response : see `Response`; rows after the first m of `row_weight` must not be negative.
    lower, upper : (N, b) or (S, N, b), limits; a control that is not free is zero all the same.
    u : (S, N, b); the first weights come from it, but the first step begins at rest.  Where the
        support is given, the first controls.
    free : (S, N, b), 1 where control is allowed.  importance : (N,), cost of an active stage.
    row_weight : (S, m), inf for rows that must vanish; w for rows that cost w/2 row^2.

    All controls of a stage count as one.  Nothing raises inside; a start that does not succeed
    shows in its residual.
    """
    count, intervals, size = u.shape
    ends = row_weight.shape[1]
    path = jax.eval_shape(response, u)[0].shape[1] - ends
    row_weight = jnp.concatenate([row_weight, jnp.full((count, path), jnp.inf, u.dtype)], axis=1)
    hard = jnp.isinf(row_weight)
    least, most = (jnp.broadcast_to(bound, u.shape) for bound in (lower, upper))

    def flat(x: Array) -> Array:
        return x.reshape(count, -1)

    def body(i: Array, point: _Point) -> _Point:
        deciding = i < settings.deciding
        smoothing = settings.smoothing * settings.factor**i
        squared = jnp.where(i == 0, u, point.u) ** 2
        squared = jnp.broadcast_to(jnp.sum(squared, axis=-1, keepdims=True), u.shape)
        freezing = (i == settings.deciding) & (i > 0)
        support = point.support * ((squared > SUPPORT_THRESHOLD**2) | ~freezing)
        chosen = (squared + smoothing**2) * (0.5 * jnp.log1p(1.0 / smoothing**2))
        # On a given support the first steps spread the torque evenly, which finds a way if any.
        early = jnp.where(settings.deciding > 0, 0.0, settings.factor**i)
        least_size = jnp.maximum(settings.settled_smoothing, early)
        spent = jnp.sqrt(point.u**2 + least_size**2) / settings.effort
        d = support * jnp.where(deciding, chosen / importance[None, :, None], spent)

        at = point.u * support
        rows, jacobian = response(at)
        wrong = jnp.concatenate([jnp.abs(rows[:, :ends]), -rows[:, ends:]], axis=1)
        far = jnp.max(jnp.where(hard, wrong, 0.0), axis=1, keepdims=True)
        share = jnp.minimum(1.0, settings.reach / jnp.maximum(far, settings.reach))
        jacobian = jacobian.reshape(count, rows.shape[1], intervals * size)
        # A path constraint that holds has nothing to be taken away, however far it holds.
        taken = jnp.concatenate(
            [rows[:, :ends] * share, jnp.where(rows > 0.0, rows, rows * share)[:, ends:]], axis=1
        )
        target = jnp.einsum("sim,sm->si", jacobian, flat(at)) - taken
        whole = jnp.sum(jacobian**2 * flat(d)[:, None], axis=-1)
        slack = jnp.where(hard, _HARD * whole, 1.0 / row_weight)
        v, dual = bounded_step(
            jacobian,
            target,
            flat(d),
            flat(least * support),
            flat(most * support),
            slack,
            jnp.where(freezing, 0.0, point.dual),
            settings.dual,
            path,
        )
        worst = jnp.max(jnp.where(hard, wrong, 0.0), axis=1)
        fresh = v.reshape(u.shape)
        moved = jnp.max(jnp.abs(fresh - at), axis=(1, 2))
        return _Point(fresh, support, dual, worst, moved)

    start = _Point(
        jnp.where(settings.deciding > 0, 0.0, u * free),
        free,
        jnp.zeros(row_weight.shape, u.dtype),
        jnp.full(u.shape[:1], jnp.inf, u.dtype),
        jnp.full(u.shape[:1], jnp.inf, u.dtype),
    )
    end = lax.fori_loop(0, settings.deciding + settings.settling, body, start)
    return BoundedRoot(end.u, end.support, end.residual, end.moved)
