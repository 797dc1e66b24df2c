"""Sparse controls by reweighting, with Riccati steps: for path constraints and large momentum.

As `reweighting`, whose weights and settings these are: every step minimises sum |u|^2 / d for
weights d that come from the last iterate, until the support has decided itself and is frozen.  But
the rows are weighted so heavily that they vanish instead of being eliminated, which keeps the
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

from jaxatt.optimize.optimal_control import OptimalControlProgram, fly
from jaxatt.optimize.reweighting.condensed import SUPPORT_THRESHOLD, Reweighting, SparseRoot
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


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class StagedReweighting:
    """Settings; all are traced.

    steps : those of the reweighting.
    row_penalty : of hard rows, so large that what is left of them does not matter.
    path_penalty : of path constraints.
    """

    steps: Reweighting
    row_penalty: float = 1e8
    path_penalty: float = 1e3


class _Point(NamedTuple):
    flown: Trajectory
    support: Array
    held: Array
    path: Array
    final: Array


def sparsify_stages(
    program: OptimalControlProgram,
    limits: Array,
    u: Array,
    free: Array,
    importance: Array,
    shared: bool,
    args: Any,
    settings: StagedReweighting,
) -> SparseRoot:
    """Controls with few active entries that bring the rows to zero, from one start.

    program : its cost is not used, and its inequalities leave the control limits out.
    limits : (l, b), rows with |l u[k]| <= 1 for every stage k.
    u : (N, b); its pattern is what makes one start differ from another: the first weights come
        from it, but the first step begins at rest.  Where the support is given, the first controls.
    free : (N, b), 1 where control is allowed.  importance : (N,), cost of an active stage.
    shared : whether a stage's controls count as one.

    Nothing raises inside; a start that does not succeed shows in its residual.
    """
    n, size = program.error_size, u.shape[1]
    first = jnp.where(settings.steps.deciding > 0, 0.0, u * free)
    x, end = fly(program, first, args)
    rows = jax.eval_shape(lambda: rows_along(program, Trajectory(x, end, first), args)[0])
    equalities, inequalities = rows.equality.shape, rows.inequality.shape
    stages = program.stages(args)
    steps = settings.steps
    dtype = u.dtype
    row_penalty = jnp.asarray(settings.row_penalty, dtype)
    path_penalty = jnp.asarray(settings.path_penalty, dtype)

    def limited(row: Array) -> tuple[Array, Array]:
        over = jnp.max(jnp.abs(jnp.sum(limits * row[None], axis=1)))
        return row / jnp.maximum(1.0, over), jnp.where(over > 1.0, 1.0, 0.0)

    def final(end: Array, multipliers: Array) -> tuple[Array, Array, Array]:
        """Value at the last node, multipliers of its path constraints and largest hard row."""

        def rows(error: Array) -> Rows:
            return final_rows(program, program.retract(end, error), args)

        weight = program.final_weights(args)
        values, jacobian = differentiated(rows, jnp.zeros(n, dtype))
        held = Rows(jnp.zeros_like(values.equality), multipliers)
        model = penalty_model(values, jacobian, held, weight, row_penalty, path_penalty)
        hard = jnp.where(jnp.isinf(weight), jnp.abs(values.equality), 0.0)
        worst = jnp.maximum(jnp.max(hard, initial=0.0), jnp.max(-values.inequality, initial=0.0))
        value = jnp.concatenate([model.hessian, model.gradient[:, None]], axis=1)
        return value, model.estimates.inequality, worst

    def laws(
        point: _Point, weights: Array, loose: Array, forced: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Feedback laws (N, b, n + 1), new path multipliers, final ones and largest violation."""
        _, end, controls = point.flown
        value, final_multipliers, worst = final(end, point.final)
        dynamics = derivatives_along(program, point.flown, args)

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

        held = Rows(jnp.zeros(equalities, dtype), point.path)
        along = models_along(program, point.flown, held, row_penalty, path_penalty, args)
        inputs = (controls, dynamics, *along, weights, loose, forced, stages)
        (_, worst), out = lax.scan(backwards, (value, worst), inputs, reverse=True)
        gains = out[:, : size * (n + 1)].reshape(-1, size, n + 1)
        return gains, out[:, size * (n + 1) :], final_multipliers, worst

    def body(i: Array, carry: tuple[_Point, Array]) -> tuple[_Point, Array]:
        point, _ = carry
        controls = point.flown.u
        deciding = i < steps.deciding
        smoothing = steps.smoothing * steps.factor**i
        squared = jnp.where(i == 0, u, controls) ** 2
        if shared:
            squared = jnp.broadcast_to(jnp.sum(squared, axis=1, keepdims=True), u.shape)
        freezing = (i == steps.deciding) & (i > 0)
        active = (squared > SUPPORT_THRESHOLD**2) | ~freezing
        support = point.support * active
        count = (squared + smoothing**2) * jnp.log1p(1.0 / smoothing**2)
        effort = jnp.sqrt(controls**2 + steps.settled_smoothing**2)
        weights = jnp.where(deciding, 0.5 * count / importance[:, None], effort)
        loose = support * (1.0 - point.held[:, None])
        forced = (support - 1.0) * controls
        gains, path, final_multipliers, worst = laws(point, weights, loose, forced)
        flown, over = fly_with_feedback(
            program, point.flown, gains, jnp.ones((), dtype), args, limited
        )
        return _Point(flown, support, over, path, final_multipliers), worst

    last = jax.eval_shape(lambda: program.final_inequalities(end, args))
    start = _Point(
        Trajectory(x, end, first),
        free,
        jnp.zeros(u.shape[0], dtype),
        jnp.zeros(inequalities, dtype),
        jnp.zeros(last.shape, dtype),
    )
    found, worst = lax.fori_loop(
        0, steps.deciding + steps.settling, body, (start, jnp.asarray(jnp.inf, dtype))
    )
    saturated = jnp.any(found.held > 0.0)
    return SparseRoot(found.flown.u, found.support, worst, saturated)
