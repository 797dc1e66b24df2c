"""Reweighting with Riccati steps, for path constraints and large momentum.

The rows are weighted so heavily that they vanish instead of being eliminated, which keeps the
problem one of stages, and the dynamics are flown under the feedback law of each step.

Controls over their limit are put on it and kept there for the next step.  Path constraints enter
as penalties whose multipliers follow at every step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize import features
from jaxatt.optimize.optimal_control import OptimalControlProgram, fly
from jaxatt.optimize.reweighting.weights import (
    Course,
    Reweighting,
    SparseRoot,
    begin,
    done,
    weigh,
)
from jaxatt.optimize.riccati.penalty import (
    Rows,
    differentiated,
    final_rows,
    models_along,
    penalty_model,
    rows_along,
)
from jaxatt.optimize.riccati.recursion import (
    StageModel,
    Trajectory,
    backward_step,
    derivatives_along,
    fly_with_feedback,
)
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.solver import Solver


class _State(NamedTuple):
    course: Course
    flown: Trajectory
    held: Array
    path: Array
    final: Array
    residual: Array


class _Laws(NamedTuple):
    """Feedback laws of a step.

    gains : (N, b, n + 1).  path, final : new multipliers.  worst : () largest violation.
    """

    gains: Array
    path: Array
    final: Array
    worst: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class StagedReweighting(Solver):
    """Find few active controls that satisfy the rows of a staged programme; a start is (N, b).

    row_penalty : of hard rows, so large that what is left of them does not matter.
    path_penalty : of path constraints.

    A start that does not succeed shows in its residual.
    """

    settings: Reweighting
    row_penalty: float = 1e8
    path_penalty: float = 1e3

    name = "reweighting over stages"
    supports = frozenset(
        {
            features.ROWS_BY_STAGE,
            features.MAGNITUDE_LIMITS,
            features.COUNTED_APART,
            features.DYNAMICS,
            features.PATH_EQUALITY,
            features.SOFT_PATH_ROWS,
            features.PATH_INEQUALITY,
            features.TERMINAL_EQUALITY,
            features.SOFT_TERMINAL_ROWS,
            features.TERMINAL_INEQUALITY,
            features.HELD_CONTROLS,
            features.MANIFOLD,
        }
    )
    needs = frozenset({features.ROWS_BY_STAGE, features.MAGNITUDE_LIMITS})
    same_passes = True

    def init(self, program: RootProgram, start: Array, args: Any) -> _State:
        """State of the flight at rest, or under the start where its support is given."""
        stages, dtype = _stages(program), start.dtype
        course, first = begin(self.settings, start, program.free(args))
        x, end = fly(stages, first, args)
        flown = Trajectory(x, end, first)
        rows = jax.eval_shape(lambda: rows_along(stages, flown, args)[0])
        last = jax.eval_shape(lambda: final_rows(stages, end, args))
        return _State(
            course,
            flown,
            jnp.zeros(start.shape[0], dtype),
            jnp.zeros(rows.inequality.shape, dtype),
            jnp.zeros(last.inequality.shape, dtype),
            jnp.asarray(jnp.inf, dtype),
        )

    def step(self, program: RootProgram, state: _State, args: Any) -> _State:
        """Take a Riccati step, flown with controls clipped at the limits."""
        assert program.limits is not None
        stages, u, limits = _stages(program), state.flown.u, program.limits(args)
        weighted = weigh(self.settings, state.course, u, program.importance(args), program.shared)
        support = weighted.course.support
        loose = support * (1.0 - state.held[:, None])
        found = self._laws(stages, state, weighted.weights, loose, (support - 1.0) * u, args)

        def limited(row: Array) -> tuple[Array, Array]:
            over = jnp.max(jnp.abs(jnp.sum(limits * row[None], axis=1)))
            return row / jnp.maximum(1.0, over), jnp.where(over > 1.0, 1.0, 0.0)

        whole = jnp.ones((), u.dtype)
        flown, held = fly_with_feedback(stages, state.flown, found.gains, whole, args, limited)
        return _State(weighted.course, flown, held, found.path, found.final, found.worst)

    def done(self, state: _State) -> Array:
        """Whether all steps have been made."""
        return done(self.settings, state.course)

    def result(self, program: RootProgram, state: _State, args: Any) -> SparseRoot:
        """Result with residual and saturation of the last step."""
        saturated = jnp.any(state.held > 0.0)
        return SparseRoot(state.flown.u, state.course.support, state.residual, saturated)

    def _laws(
        self,
        program: OptimalControlProgram,
        state: _State,
        weights: Array,
        loose: Array,
        forced: Array,
        args: Any,
    ) -> _Laws:
        """Feedback laws of the next step."""
        controls = state.flown.u
        n, size, dtype = program.error_size, controls.shape[1], controls.dtype
        value, final_multipliers, worst = self._last(program, state, args)
        dynamics = derivatives_along(program, state.flown, args)

        def backwards(carry: tuple[Array, Array], inputs: Any) -> tuple[Any, Array]:
            value, worst = carry
            u, matrix, values, model, weight, loose, forced, stage = inputs

            row_weight = program.equality_weights(stage, args)
            worst = jnp.maximum(worst, jnp.max(-values.inequality, initial=0.0))
            hard = jnp.where(jnp.isinf(row_weight), jnp.abs(values.equality), 0.0)
            worst = jnp.maximum(worst, jnp.max(hard, initial=0.0))
            stiffness = jnp.where(loose > 0, 1.0 / weight, 0.0)
            diagonal = jnp.concatenate([jnp.zeros(n, dtype), stiffness])
            pull = jnp.concatenate([jnp.zeros(n, dtype), stiffness * u])
            stage_model = StageModel(
                matrix,
                model.hessian + diagonal[:, None] * jnp.eye(n + size, dtype=dtype),
                model.gradient + pull,
            )
            value, law, _, _ = backward_step(
                value, stage_model, loose, forced, jnp.zeros((), dtype)
            )
            out = jnp.concatenate([law.ravel(), model.estimates.inequality])
            return (value, worst), out

        equalities = jax.eval_shape(lambda: rows_along(program, state.flown, args)[0]).equality
        held = Rows(jnp.zeros(equalities.shape, dtype), state.path)
        row_penalty, path_penalty = self._penalties(dtype)
        along = models_along(program, state.flown, held, row_penalty, path_penalty, args)
        inputs = (controls, dynamics, *along, weights, loose, forced, program.stages(args))
        (_, worst), out = lax.scan(backwards, (value, worst), inputs, reverse=True)
        gains = out[:, : size * (n + 1)].reshape(-1, size, n + 1)
        return _Laws(gains, out[:, size * (n + 1) :], final_multipliers, worst)

    def _last(
        self, program: OptimalControlProgram, state: _State, args: Any
    ) -> tuple[Array, Array, Array]:
        """Value at the last node, multipliers of its path constraints and largest violation."""
        end, dtype = state.flown.end, state.flown.u.dtype

        def rows(error: Array) -> Rows:
            return final_rows(program, program.retract(end, error), args)

        weight = program.final_weights(args)
        values, jacobian = differentiated(rows, jnp.zeros(program.error_size, dtype))
        held = Rows(jnp.zeros_like(values.equality), state.final)
        model = penalty_model(values, jacobian, held, weight, *self._penalties(dtype))
        hard = jnp.where(jnp.isinf(weight), jnp.abs(values.equality), 0.0)
        worst = jnp.maximum(jnp.max(hard, initial=0.0), jnp.max(-values.inequality, initial=0.0))
        value = jnp.concatenate([model.hessian, model.gradient[:, None]], axis=1)
        return value, model.estimates.inequality, worst

    def _penalties(self, dtype: Any) -> tuple[Array, Array]:
        """Penalties of hard rows and of path constraints, ()."""
        return jnp.asarray(self.row_penalty, dtype), jnp.asarray(self.path_penalty, dtype)


def _stages(program: RootProgram) -> OptimalControlProgram:
    assert program.stages is not None
    return program.stages
