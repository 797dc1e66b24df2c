"""Reweighting by weighted least-norm Newton steps on the rows alone.

The step is  min sum |v|^2 / d  subject to  J (v - u) = -r.  Few rows make it a system of their own
small size, whatever the number of controls.

Controls over their limit are put on it and kept there for the next step, which lets them go as soon
as it wants less of them; so saturation holds exactly at every iterate.  A stage on its limit has no
freedom to turn, so where nearly all stages saturate this can fail although there is an answer;
`SparseRoot.saturated` tells those starts apart.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.batch_last import batch_last
from jaxatt.optimize.reweighting.weights import (
    Course,
    Reweighting,
    SparseRoot,
    begin,
    done,
    total,
    weigh,
)
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.small_systems import solve_spd
from jaxatt.optimize.solver import Solver

_DAMPING = 1e-12
_NOTHING = 1e-300


class _State(NamedTuple):
    course: Course
    u: Array
    held: Array
    residual: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class CondensedReweighting(Solver):
    """Find few active controls that satisfy the rows; a start is (N, b).

    A start that does not succeed shows in its residual.
    """

    settings: Reweighting

    name = "reweighting"
    supports = frozenset({features.ROWS_AT_ONCE, features.MAGNITUDE_LIMITS, features.COUNTED_APART})
    needs = frozenset({features.ROWS_AT_ONCE, features.MAGNITUDE_LIMITS})
    same_passes = True

    def init(self, program: RootProgram, start: Array, args: Any) -> _State:
        """State at rest, or at the start where its support is given."""
        course, u = begin(self.settings, start, program.free(args))
        infinite = jnp.asarray(jnp.inf, start.dtype)
        return _State(course, u, jnp.zeros(start.shape[0], bool), infinite)

    def step(self, program: RootProgram, state: _State, args: Any) -> _State:
        """Take a step of least weighted norm, clipped at the limits."""
        row_weight = program.row_weight(args)
        hard = jnp.isinf(row_weight)
        weighted = weigh(
            self.settings, state.course, state.u, program.importance(args), program.shared
        )
        support, weights = weighted.course.support, weighted.weights
        before, gradual = state.u * support, self.settings.gradual
        if gradual is not None:
            near = jnp.maximum(_nearness(program, before, args), _NOTHING)
            level = jnp.minimum(1.0, (gradual.level / near) ** 2)
            weights = weights * jnp.where(weighted.deciding, level, 1.0)[:, None]
        loose = jnp.where(state.held[:, None], 0.0, support)
        found = program.linearise(args)(
            before, weights * loose, state.u * loose, ~weighted.deciding
        )
        shares = _shares(found.matrix, found.reached - found.rows, row_weight)
        fresh = weights * found.pullback(shares)
        if gradual is not None:
            most = gradual.reach * _sum_of_lengths(before)
            changed = jnp.maximum(_sum_of_lengths(fresh - before), _NOTHING)
            share = jnp.minimum(gradual.share, most / changed)
            fresh = jnp.where(weighted.deciding, before + share * (fresh - before), fresh)
        over = _nearness(program, fresh, args)
        return _State(
            weighted.course,
            fresh / jnp.maximum(1.0, over)[:, None],
            over > 1.0,
            jnp.max(jnp.where(hard, jnp.abs(found.rows), 0.0)),
        )

    def done(self, state: _State) -> Array:
        """Whether all steps have been made."""
        return done(self.settings, state.course)

    def result(self, program: RootProgram, state: _State, args: Any) -> SparseRoot:
        """Result with residual and saturation of the last step."""
        return SparseRoot(state.u, state.course.support, state.residual, jnp.any(state.held))


@batch_last
def _shares(matrix: Array, missing: Array, row_weight: Array) -> Array:
    """What every row has to push, (m,), for what it misses, with J diag(weights) J' (m, m)."""
    size = len(missing)
    diagonal = jnp.stack([matrix[k, k] for k in range(size)])
    slack = jnp.where(jnp.isinf(row_weight), _DAMPING * diagonal, 1.0 / row_weight) + _NOTHING
    return solve_spd(matrix, missing, slack)


def _sum_of_lengths(u: Array) -> Array:
    """Sum over the stages of the lengths of their controls (N, b), whatever the axes."""
    return jnp.sum(jnp.sqrt(total(u**2)))


def _nearness(program: RootProgram, u: Array, args: Any) -> Array:
    """Controls (N, b) in units of the limits that they come nearest to, (N,)."""
    assert program.limits is not None
    relative = (jnp.abs(total(u * row[None])) for row in program.limits(args))
    return functools.reduce(jnp.maximum, relative)
