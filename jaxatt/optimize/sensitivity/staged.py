"""First-order conditions of an optimal-control programme, stage by stage."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded, Duals, Model, Nodes, limits_along, model
from jaxatt.optimize.interior_point.step import times
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.sensitivity.condensing import condensed
from jaxatt.optimize.sensitivity.conditions import Condensed, Conditions
from jaxatt.optimize.sensitivity.curvature import differenced
from jaxatt.optimize.sensitivity.dense import held_by
from jaxatt.optimize.sensitivity.recursion import StageResiduals, staged_step


class StagedPoint(NamedTuple):
    """Variables and multipliers of all stages; a step has error coordinates in place of `x`.

    begin : (f,), the decided coordinates of the first state, as errors from the programme's start.
    x : (N, s), states at nodes 1 to N.  u : (N, b).  costates : (N, n), of the dynamics.
    equality : (N, q).  rows : (r,).  limits : multipliers of the inequalities.
    """

    begin: Array
    x: Array
    u: Array
    costates: Array
    equality: Array
    rows: Array
    limits: Bounded


class StagedSystem(NamedTuple):
    """Second-order model at a point, and margins (N, b) to the limits of the controls."""

    model: Model
    lower: Array
    upper: Array


@dataclass(frozen=True)
class StagedConditions(Conditions):
    """Conditions of an `OptimalControlProgram` without soft rows and held controls.

    Derivatives are the programme's own, as in the interior-point method.
    """

    program: OptimalControlProgram

    def first(self, point: StagedPoint, args: Any) -> Array:
        """State at the first node, (s,)."""
        return self._begun(point.begin, args)

    def _begun(self, begin: Array, args: Any) -> Array:
        start = self.program.start(args)
        if not self.program.free_start:
            return start
        given = jnp.zeros(self.program.error_size - self.program.free_start, start.dtype)
        return self.program.retract(start, jnp.concatenate([given, begin]))

    def lagrangian(
        self, point: StagedPoint, step: StagedPoint, args: Any, active: Bounded
    ) -> Array:
        program = self.program
        first = self._begun(point.begin + step.begin, args)
        ahead = jax.vmap(program.retract)(point.x, step.x)
        at = jnp.concatenate([first[None], ahead[:-1]])
        u = point.u + step.u
        dual = jax.tree.map(jnp.add, point.limits, step.limits)

        def of(
            x: Array,
            u: Array,
            node: Array,
            error: Array,
            costate: Array,
            held: Array,
            path: Array,
            holds: Array,
            stage: Any,
        ) -> Array:
            end, cost = program.next_and_cost(x, u, stage, args)
            # The next state's error enters as itself, so that the matrix is that of the solver.
            gap = program.difference(end, node) - error
            total = cost + jnp.sum(costate * gap)
            if held.shape[0]:
                total = total + jnp.sum(held * program.equalities(x, u, stage, args))
            if path.shape[0]:
                total = total - held_by(holds, path, program.inequalities(x, u, stage, args))
            return total

        stages = jax.vmap(of)(
            at,
            u,
            point.x,
            step.x,
            point.costates + step.costates,
            point.equality + step.equality,
            dual.path,
            active.path,
            program.stages(args),
        )
        end = ahead[-1]
        total = jnp.sum(stages) + program.final_cost(end, args)
        total = total + jnp.sum((point.rows + step.rows) * program.final_equalities(end, args))
        lower, upper = self._limits(u, args)
        kept = Bounded(jnp.zeros((0,)), program.final_inequalities(end, args), lower, upper)
        nothing = jnp.zeros((0,))
        return total - held_by(
            active._replace(path=nothing > 0.0), dual._replace(path=nothing), kept
        )

    def _limits(self, u: Array, args: Any) -> tuple[Array, Array]:
        low, high = limits_along(self.program, u.shape[1], args)
        return u - low, high - u

    def _states(self, point: StagedPoint, args: Any) -> Array:
        """States at all nodes, (N + 1, s)."""
        return jnp.concatenate([self.first(point, args)[None], point.x])

    def objective(self, point: StagedPoint, args: Any) -> Array:
        program, x = self.program, self._states(point, args)

        def cost(x: Array, u: Array, stage: Any) -> Array:
            return program.next_and_cost(x, u, stage, args)[1]

        stages = jax.vmap(cost)(x[:-1], point.u, program.stages(args))
        return jnp.sum(stages) + program.final_cost(x[-1], args)

    def margins(self, point: StagedPoint, args: Any) -> Bounded:
        program, x = self.program, self._states(point, args)

        def of(x: Array, u: Array, stage: Any) -> Array:
            return program.inequalities(x, u, stage, args)

        path = jax.vmap(of)(x[:-1], point.u, program.stages(args))
        final = program.final_inequalities(x[-1], args)
        return Bounded(path, final, *self._limits(point.u, args))

    def multipliers(self, point: StagedPoint) -> Bounded:
        return point.limits

    def released(self, point: StagedPoint, active: Bounded) -> StagedPoint:
        limits = jax.tree.map(lambda a, z: jnp.where(a, z, 0.0), active, point.limits)
        return point._replace(limits=limits)

    def zero(self, point: StagedPoint) -> StagedPoint:
        rest = jnp.zeros((len(point.x), self.program.error_size), point.x.dtype)
        return jax.tree.map(jnp.zeros_like, point)._replace(x=rest)

    def moved(self, point: StagedPoint, step: StagedPoint) -> StagedPoint:
        added = jax.tree.map(jnp.add, point._replace(x=step.x), step)
        return added._replace(x=jax.vmap(self.program.retract)(point.x, step.x))

    def system(self, point: StagedPoint, args: Any) -> StagedSystem:
        x = self._states(point, args)
        duals = Duals(point.equality, point.rows, point.limits.path, point.limits.final)
        found = model(self.program, Nodes(x[:-1], x[-1], point.u), duals, args, point.costates)
        return StagedSystem(found, *self._limits(point.u, args))

    def residual(self, system: StagedSystem, point: StagedPoint, active: Bounded) -> StagedPoint:
        found, n = system.model, self.program.error_size
        off = point.costates - found.costates
        # What the gradient changes by from the costates of the adjoint recursion.
        by = found.gradient + times(jnp.swapaxes(found.dynamics, 1, 2), off)
        own, limits = point.costates, point.limits
        by_states = jnp.concatenate([by[1:, :n] - own[:-1], (found.costates - own)[-1:]])
        left = Bounded(found.path, found.final, system.lower, system.upper)
        return StagedPoint(
            by[0, n - self.program.free_start : n],
            by_states,
            by[:, n:] - limits.lower + limits.upper,
            found.gap,
            found.equality,
            found.rows,
            jax.tree.map(lambda a, m, z: jnp.where(a, -m, -z), active, left, limits),
        )

    def solve(self, system: StagedSystem, active: Bounded, right: StagedPoint) -> StagedPoint:
        found = staged_step(system.model, active, StageResiduals(*right), self.program.free_start)
        return StagedPoint(*found)

    def condensed(self, system: StagedSystem, point: StagedPoint) -> Condensed:
        return condensed(jax.tree.map(np.asarray, system.model), self.program.free_start)

    def labels(self, point: StagedPoint) -> tuple[str, ...]:
        count, rows = point.limits.path.shape
        own = [f"path row {i}, interval {k}" for k in range(count) for i in range(rows)]
        own += [f"terminal row {i}" for i in range(len(point.limits.final))]
        for side in ("lower", "upper"):
            own += [
                f"{side} limit of control {j}, interval {k}"
                for k in range(count)
                for j in range(point.u.shape[1])
            ]
        return tuple(own)


@dataclass(frozen=True)
class LinearisedConditions(StagedConditions):
    """The same for a programme whose own linearisation is exact.

    The gradient is made of it, which compiles several times faster than one that is found by
    differentiating the dynamics backwards.
    """

    runs_once = True

    def gradient(self, point: StagedPoint, args: Any, active: Bounded) -> StagedPoint:
        straight = LinearisedConditions(_without_curvature(self.program))
        return self.residual(straight.system(point, args), point, active)


def _without_curvature(program: OptimalControlProgram) -> OptimalControlProgram:
    """The same to first order, so that nothing is traced on which the gradient does not depend."""

    def none(x: Array, u: Array, *_: Any) -> Array:
        size = program.error_size + u.shape[0]
        return jnp.zeros((size, size), u.dtype)

    return replace(program, lagrangian_hessian=none, path_hessian=none)


@dataclass(frozen=True)
class SteppedConditions(LinearisedConditions):
    """The same for a programme whose linearisation is found by differentiating its steps.

    To differentiate it once more by the parameters takes a compiler minutes.  So what the stages
    change by along a tangent is found first, and its derivatives by states and controls are central
    differences, right to nine digits.
    """

    def pull(self, point: StagedPoint, args: Any, active: Bounded, along: Any) -> StagedPoint:
        program, n, free = self.program, self.program.error_size, self.program.free_start
        dual, size = point.limits, point.u.shape[1]
        following = point.x

        def stages(z: Array, args: Any) -> tuple[Array, tuple[Array, Array]]:
            """What all stages add to L, (N,), and gaps and equalities, all at an error z."""

            def of(
                x: Array, u: Array, ahead: Array, costate: Array, held: Array, path: Array, at: Any
            ) -> tuple[Array, tuple[Array, Array]]:
                x, u = program.retract(x, z[:n]), u + z[n:]
                end, cost = program.next_and_cost(x, u, at, args)
                gap, missed = program.difference(end, ahead), program.equalities(x, u, at, args)
                left = jnp.sum(path * program.inequalities(x, u, at, args))
                total = cost + jnp.sum(costate * gap) + jnp.sum(held * missed) - left
                return total, (gap, missed)

            x = self._states(point, args)[:-1]
            own = (x, point.u, following, point.costates, point.equality, dual.path)
            return jax.vmap(of)(*own, program.stages(args))

        def changed(z: Array) -> tuple[Array, tuple[Array, Array]]:
            return jax.jvp(lambda args: stages(z, args), (args,), (along,))[1]

        by = differenced(lambda z: changed(z)[0], n + size)
        gap, missed = changed(jnp.zeros(n + size))[1]

        def ended(args: Any) -> tuple[Array, Array, Bounded]:
            def last(error: Array) -> Array:
                x = program.retract(following[-1], error)
                hard, soft = program.final_equalities(x, args), program.final_inequalities(x, args)
                total = jnp.sum(point.rows * hard) - jnp.sum(dual.final * soft)
                return total + program.final_cost(x, args)

            hard = program.final_equalities(following[-1], args)
            return jax.grad(last)(jnp.zeros(n)), hard, self.margins(point, args)

        at_end, hard, margins = jax.jvp(ended, (args,), (along,))[1]
        change = StagedPoint(
            by[0, n - free : n],
            jnp.concatenate([by[1:, :n], at_end[None]]),
            by[:, n:],
            gap,
            missed,
            hard,
            jax.tree.map(lambda a, m: jnp.where(a, -m, 0.0), active, margins),
        )
        return jax.tree.map(jnp.negative, change)
