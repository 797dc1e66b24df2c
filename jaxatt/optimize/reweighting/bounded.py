"""Reweighting for controls with bounds of their own, where saturation is the rule.

Every step respects lower <= u <= upper exactly, which one-sided actuators need.  It is the
quadratic programme

    min  sum v^2 / (2 d)  +  sum w/2 (r + J (v - u))^2   subject to   lower <= v <= upper,

w infinite for hard rows.  Its dual has as many variables as there are rows, is concave and once
differentiable; a few damped Newton steps on it end at v = clip(d J'y, lower, upper).

Rows after those may be one-sided, path constraints that must not be negative: their dual variables
must not be either, and the Newton steps are projected (Bertsekas 1982).

Sources: Qi and Sun (1993) for Newton's method on piecewise smooth equations; Bertsekas (1982),
"Projected Newton methods for optimization problems with simple constraints".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize import features
from jaxatt.optimize.batch_last import batch_last
from jaxatt.optimize.reweighting.weights import (
    Course,
    Reweighting,
    SparseRoot,
    begin,
    done,
    weigh,
)
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.small_systems import solve_spd
from jaxatt.optimize.solver import Solver

_STEPS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
_DAMPING = 1e-9
_FAR = 1e-2
_HARD = 1e-13
_NOTHING = 1e-300

BETWEEN_BOUNDS = Reweighting(smoothing=0.3, factor=0.6, settling=4, spreading=1.0)
"""Settings that decide supports, from controls of any size."""

_solve = batch_last(solve_spd)


class _State(NamedTuple):
    course: Course
    u: Array
    dual: Array
    residual: Array
    moved: Array


def _clipped(d: Array, pull: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Minimiser of v^2/(2 d) - pull v between bounds, and the negative of the minimum."""
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
    """Solve the quadratic programme of a step: controls (M,) and dual variables (m,).

    jacobian : (m, M).  target : (m,), what J v should be.  d, lower, upper : (M,).
    slack : (m,), 1/w.  one_sided : how many of the last rows J v may exceed their target.
    """
    sided = jnp.arange(target.shape[0]) >= target.shape[0] - one_sided
    eye = jnp.eye(target.shape[0], dtype=target.dtype)

    def value(y: Array) -> Array:
        _, kept = _clipped(d, jnp.einsum("im,i->m", jacobian, y), lower, upper)
        return jnp.sum(kept, axis=-1) + jnp.sum(0.5 * slack * y**2 - target * y, axis=-1)

    def newton(_: Array, y: Array) -> Array:
        pull = jnp.einsum("im,i->m", jacobian, y)
        wanted = d * pull
        v = jnp.clip(wanted, lower, upper)
        inside = jnp.where((wanted >= lower) & (wanted <= upper), d, 0.0)
        gradient = jnp.einsum("im,m->i", jacobian, v) + slack * y - target
        loose = sided & (y <= 0.0) & (gradient >= 0.0)
        gradient = jnp.where(loose, 0.0, gradient)
        curvature = jnp.einsum("im,jm->ij", jacobian * inside[None], jacobian)
        whole = jnp.sum(jacobian**2 * d[None], axis=-1)
        missed = jnp.linalg.norm(gradient) / (jnp.linalg.norm(target) + _NOTHING)
        damping = slack + (_DAMPING + _FAR * jnp.minimum(1.0, missed)) * whole + _NOTHING
        matrix = curvature + damping[:, None] * eye
        apart = (loose[:, None] | loose[None, :]) & (eye == 0.0)
        step = _solve(jnp.where(apart, 0.0, matrix), -gradient)
        tried = jnp.stack([y + s * step for s in _STEPS])
        tried = jnp.where(sided[None], jnp.maximum(0.0, tried), tried)
        return tried[jnp.argmin(jax.vmap(value)(tried))]

    y = lax.fori_loop(0, steps, newton, start)
    return jnp.clip(d * jnp.einsum("im,i->m", jacobian, y), lower, upper), y


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class BoundedReweighting(Solver):
    """Find few active stages between bounds that satisfy the rows; a start is (N, b).

    dual : Newton steps on the dual in each step.
    reach : [rad] largest row that one step may take away, so that linearisations hold.

    A control that is not free is zero whatever its bounds.  A start that does not succeed shows in
    its residual.
    """

    settings: Reweighting = BETWEEN_BOUNDS
    dual: int = 6
    reach: float = 1.0

    name = "reweighting between bounds"
    supports = frozenset({features.ROWS_AT_ONCE, features.SEPARATE_BOUNDS, features.ONE_SIDED_ROWS})
    needs = frozenset({features.ROWS_AT_ONCE, features.SEPARATE_BOUNDS})
    same_passes = True
    batch_axis = 0

    def init(self, program: RootProgram, start: Array, args: Any) -> _State:
        """State at rest, or at the start where its support is given."""
        course, u = begin(self.settings, start, program.free(args))
        infinite = jnp.asarray(jnp.inf, start.dtype)
        rows = jax.eval_shape(lambda u: _rows(program, u, args), u)[0]
        return _State(course, u, jnp.zeros(rows.shape, start.dtype), infinite, infinite)

    def step(self, program: RootProgram, state: _State, args: Any) -> _State:
        """Take a step of least weighted norm between the bounds."""
        assert program.bounds is not None
        weighted = weigh(
            self.settings, state.course, state.u, program.importance(args), program.shared
        )
        support, d = weighted.course.support, weighted.weights
        least, most = (jnp.broadcast_to(bound, d.shape) for bound in program.bounds(args))
        at = state.u * support
        rows, jacobian = batch_last(lambda u, args: _rows(program, u, args))(at, args)
        ends = program.row_weight(args).shape[0]
        path = rows.shape[0] - ends
        row_weight = jnp.concatenate([program.row_weight(args), jnp.full(path, jnp.inf, d.dtype)])
        hard = jnp.isinf(row_weight)
        wrong = jnp.concatenate([jnp.abs(rows[:ends]), -rows[ends:]])
        worst = jnp.max(jnp.where(hard, wrong, 0.0))
        share = jnp.minimum(1.0, self.reach / jnp.maximum(worst, self.reach))
        jacobian = jacobian.reshape(rows.shape[0], -1)
        # A path constraint that holds has nothing to be taken away, however far it holds.
        taken = jnp.concatenate(
            [rows[:ends] * share, jnp.where(rows > 0.0, rows, rows * share)[ends:]]
        )
        target = jnp.einsum("im,m->i", jacobian, at.ravel()) - taken
        whole = jnp.sum(jacobian**2 * d.ravel()[None], axis=-1)
        v, dual = bounded_step(
            jacobian,
            target,
            d.ravel(),
            (least * support).ravel(),
            (most * support).ravel(),
            jnp.where(hard, _HARD * whole, 1.0 / row_weight),
            jnp.where(weighted.freezing, 0.0, state.dual),
            self.dual,
            path,
        )
        fresh = v.reshape(d.shape)
        return _State(weighted.course, fresh, dual, worst, jnp.max(jnp.abs(fresh - at)))

    def done(self, state: _State) -> Array:
        """Whether all steps have been made."""
        return done(self.settings, state.course)

    def result(self, program: RootProgram, state: _State, args: Any) -> SparseRoot:
        """Result; bounds hold at every step, so saturation needs no check."""
        saturated = jnp.zeros((), bool)
        return SparseRoot(state.u, state.course.support, state.residual, saturated, state.moved)


def _rows(program: RootProgram, u: Array, args: Any) -> tuple[Array, Array]:
    """All rows (m + K,), the one-sided ones last, and their derivatives (m + K, N, b)."""
    assert program.response is not None
    rows, derivatives = program.response(u, args)
    if program.path is not None:
        path, slopes = program.path(u, args)
        rows = jnp.concatenate([rows, path])
        derivatives = jnp.concatenate([derivatives, slopes], axis=1)
    return rows, jnp.swapaxes(derivatives, 0, 1)
