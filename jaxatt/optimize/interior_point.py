"""Primal-dual interior-point method over stages, from one start; `jax.vmap` makes it many.

    minimise    sum of cost(x_k, u_k)
    subject to  x_(k+1) = dynamics(x_k, u_k),  final_rows(x_N) = 0,
                lower <= u_k <= upper,  inequality(x_k, u_k) >= 0,  final_inequality(x_N) >= 0

over the controls, the states (multiple shooting) and those coordinates of the first state that the
programme leaves free.  A pass of the loop differentiates all stages twice, makes a Riccati
recursion for the Newton step of the barrier problem, and moves along it as far as the limits and a
filter allow.  Second derivatives are exact; where the reduced Hessian is not positive definite the
curvature is shifted until it is.  Hard rows at the end enter with a large quadratic weight around
their multipliers, which is a tiny regularisation of the dual system that the next step corrects.

Sources: Waechter and Biegler (2006), "On the implementation of an interior-point filter line-search
algorithm for large-scale nonlinear programming", for barrier, shift and fraction to the boundary;
Vanroye, De Schutter and Decre (2023), "FATROP: a fast constrained optimal control problem solver
for robot trajectory optimization and control", for the Riccati recursion in such a method.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.interior_model import Bounded, Nodes, Values, limits_along, model, values
from jaxatt.optimize.interior_step import Step, newton_step
from jaxatt.optimize.status import Status
from jaxatt.problems.staged import StagedProgram

_RUNNING = -1
_LARGE_MULTIPLIER = 100.0
_SOLVED_TO = 10.0
"""A barrier problem counts as solved at this many times its barrier."""
_TO_BOUNDARY = 0.99
_PUSH = 1e-2
_SHORTER = 0.3
_MOST_TRIALS = 4
_PROGRESS = 1e-4
_NEGLIGIBLE = 1e-7
_FIRST_SHIFT = 1e-4
_GROWTH = 10.0
_DUAL_RANGE = 1e10
_STUCK = 1e8
_TINY = 1e-300


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class InteriorSettings:
    """Settings; all are traced.

    tolerance : of violation, scaled stationarity and complementarity.
    barrier : the first one.  factor, power : a solved barrier b becomes min(factor b, b^power).
    row_penalty : of the hard rows at the end.  max_iterations : passes.
    """

    tolerance: float = 1e-8
    barrier: float = 0.02
    factor: float = 0.1
    power: float = 1.5
    row_penalty: float = 1e7
    max_iterations: int = 200


class InteriorSolution(NamedTuple):
    """Where a start ended.

    x : (N + 1, s), states.  u : (N, b).  objective : ().  status : () a `Status`.
    violation : (), largest of gaps, hard rows and inequalities.  stationarity : (), largest of the
    Lagrangian's scaled gradient and the complementarity.  Both hold at the returned point, with
    exact derivatives.  rows : (r,) and dual : multipliers.  iterations : () passes.
    """

    x: Array
    u: Array
    objective: Array
    status: Array
    violation: Array
    stationarity: Array
    rows: Array
    dual: Bounded
    iterations: Array


class _Point(NamedTuple):
    nodes: Nodes
    path: Array
    final: Array
    dual: Bounded
    rows: Array


class _State(NamedTuple):
    point: _Point
    barrier: Array
    shift: Array
    most: Array
    cost: Array
    unmet: Array
    status: Array
    iterations: Array
    violation: Array
    stationarity: Array


class _Trial(NamedTuple):
    """The last step length tried, how many there were, and what was found there."""

    trials: Array
    length: Array
    cost: Array
    unmet: Array
    accepted: Array


def _largest(values: Array) -> Array:
    return jnp.max(jnp.abs(values), initial=0.0)


def _to_boundary(value: Bounded, step: Bounded, share: Array) -> Array:
    """Longest step up to 1 that leaves 1 - share of every value at least."""

    def of(v: Array, dv: Array) -> Array:
        ratio = jnp.where(dv < 0.0, -share * v / jnp.minimum(dv, -_TINY), 1.0)
        return jnp.min(ratio, initial=1.0)

    lengths = jax.tree.leaves(jax.tree.map(of, value, step))
    return jnp.min(jnp.stack(lengths))


def solve_interior(
    program: StagedProgram,
    u: Array,
    states: Array,
    args: Any,
    settings: InteriorSettings,
) -> InteriorSolution:
    """Minimise a `StagedProgram` from one start.

    u : (N, b) and states : (N + 1, s), which need not obey the dynamics.

    Nothing raises inside; the outcome is in `InteriorSolution.status`.
    """
    dtype = u.dtype
    lower, upper = limits_along(program, u.shape[1], args)
    below, above = jnp.isfinite(lower), jnp.isfinite(upper)
    low, high = jnp.where(below, lower, 0.0), jnp.where(above, upper, 0.0)
    tolerance = jnp.asarray(settings.tolerance, dtype)

    def slacks(point: _Point) -> Bounded:
        u = point.nodes.u
        return Bounded(
            point.path, point.final, jnp.where(below, u - low, 1.0), jnp.where(above, high - u, 1.0)
        )

    def only_there(of: Bounded) -> Bounded:
        """Without limits that are infinite."""
        return of._replace(
            lower=jnp.where(below, of.lower, 0.0), upper=jnp.where(above, of.upper, 0.0)
        )

    def unmet(found: Values, point: _Point) -> Array:
        excess = jnp.sum(jnp.abs(found.path - point.path))
        return found.unmet + excess + jnp.sum(jnp.abs(found.final - point.final))

    def merit(cost: Array, point: _Point, barrier: Array) -> Array:
        logs = jax.tree.leaves(jax.tree.map(lambda s: jnp.sum(jnp.log(s)), slacks(point)))
        return cost - barrier * sum(logs)

    def along(point: _Point, step: Step, length: Array) -> _Point:
        nodes = point.nodes
        return point._replace(
            nodes=Nodes(
                jax.vmap(program.retract)(nodes.x, length * step.x),
                program.retract(nodes.end, length * step.end),
                nodes.u + length * step.u,
            ),
            path=point.path + length * step.slack.path,
            final=point.final + length * step.slack.final,
        )

    def body(state: _State) -> _State:
        point = state.point
        slack, dual = slacks(point), point.dual
        found = model(program, point.nodes, point.rows, dual.path, dual.final, args)
        n = program.error_size
        by_control = found.gradient[:, n:] - dual.lower + dual.upper
        by_start = found.costate[n - program.free_start :]
        gradient = jnp.maximum(_largest(by_control), _largest(by_start))
        multipliers = jnp.stack([_largest(m) for m in (*dual, point.rows)])
        scale = jnp.maximum(1.0, jnp.max(multipliers) / _LARGE_MULTIPLIER)
        gaps = jnp.maximum(_largest(found.gap), _largest(found.rows))
        short = jnp.maximum(
            _largest(jnp.minimum(found.path, 0.0)), _largest(jnp.minimum(found.final, 0.0))
        )
        excess = jnp.maximum(_largest(found.path - slack.path), _largest(found.final - slack.final))

        def slackness(barrier: Array) -> Array:
            left = only_there(jax.tree.map(lambda z, s: z * s - barrier, dual, slack))
            return jnp.max(jnp.stack([_largest(part) for part in left]))

        def error(barrier: Array) -> Array:
            stationary = jnp.maximum(gradient, slackness(barrier)) / scale
            return jnp.maximum(stationary, jnp.maximum(gaps, excess))

        barrier = state.barrier
        for _ in range(2):
            lower_barrier = jnp.minimum(settings.factor * barrier, barrier**settings.power)
            solved = error(barrier) <= _SOLVED_TO * barrier
            least = jnp.minimum(barrier, 0.1 * tolerance)
            barrier = jnp.where(solved, jnp.maximum(least, lower_barrier), barrier)
        violation = jnp.maximum(gaps, short)
        stationarity = jnp.maximum(gradient, slackness(jnp.zeros((), dtype))) / scale
        finite = jnp.isfinite(violation) & jnp.isfinite(stationarity)
        converged = (violation <= tolerance) & (stationarity <= tolerance) & (excess <= tolerance)

        step = newton_step(
            found,
            slack,
            dual,
            barrier,
            jnp.asarray(settings.row_penalty, dtype),
            program.free_start,
            state.shift,
        )
        dual_step = only_there(step.dual)
        share = jnp.maximum(_TO_BOUNDARY, 1.0 - barrier)
        longest = _to_boundary(slack, only_there(step.slack), share)
        dual_length = _to_boundary(dual, dual_step, share)
        unmet_now, merit_now = state.unmet, merit(state.cost, point, barrier)

        def rejected(tried: _Trial) -> Array:
            return ~(tried.accepted | (tried.trials >= _MOST_TRIALS))

        def attempt(last: _Trial) -> _Trial:
            length = jnp.where(last.trials == 0, longest, _SHORTER * last.length)
            trial = along(point, step, length)
            seen = values(program, trial.nodes, args)
            miss, cost = unmet(seen, trial), merit(seen.cost, trial, barrier)
            nearer = miss <= (1.0 - 10.0 * _PROGRESS * length) * unmet_now
            cheaper = cost <= merit_now - _PROGRESS * jnp.minimum(unmet_now, 1.0)
            level = (miss <= _NEGLIGIBLE) & (cost <= merit_now + 1e-10 * jnp.abs(merit_now))
            good = (miss <= state.most) & (nearer | cheaper | level)
            good = good & jnp.isfinite(miss) & jnp.isfinite(cost)
            return _Trial(last.trials + 1, length, seen.cost, miss, good)

        none = _Trial(jnp.asarray(0), longest, state.cost, state.unmet, ~step.convex)
        tried = lax.while_loop(rejected, attempt, none)
        accepted = tried.accepted & step.convex
        length = jnp.where(accepted, tried.length, 0.0)
        trial = along(point, step, length)
        moved = trial._replace(
            dual=jax.tree.map(lambda z, dz: z + dual_length * dz, dual, dual_step),
            rows=point.rows + length * step.rows,
        )
        bounds = jax.tree.map(lambda s: barrier / s, slacks(moved))
        kept = jax.tree.map(
            lambda z, b: jnp.clip(z, b / _DUAL_RANGE, b * _DUAL_RANGE), moved.dual, bounds
        )
        moved = moved._replace(dual=only_there(kept))
        # A model that is not convex, or a step that leads nowhere, asks for more curvature.
        more = jnp.maximum(_FIRST_SHIFT, jnp.where(state.shift > 0.0, _GROWTH * state.shift, 0.0))
        less = jnp.where(state.shift < 3.0 * _FIRST_SHIFT, 0.0, state.shift / 3.0)
        shift = jnp.where(accepted, less, more)
        status = jnp.where(
            ~finite,
            Status.NOT_FINITE,
            jnp.where(
                converged,
                Status.CONVERGED,
                jnp.where(shift > _STUCK, Status.INFEASIBLE, _RUNNING),
            ),
        )
        # The last pass only looks, so that what is said of the point returned is true of it.
        looking = state.iterations + 1 >= settings.max_iterations
        going = (status == _RUNNING) & accepted & ~looking
        return _State(
            jax.tree.map(lambda new, old: jnp.where(going, new, old), moved, point),
            barrier,
            shift,
            state.most,
            jnp.where(going, tried.cost, state.cost),
            jnp.where(going, tried.unmet, state.unmet),
            status,
            state.iterations + jnp.where(status == _RUNNING, 1, 0),
            violation,
            stationarity,
        )

    def running(state: _State) -> Array:
        return (state.status == _RUNNING) & (state.iterations < settings.max_iterations)

    start = _first_point(program, u, states, args, settings, (below, above, low, high))
    seen = values(program, start.nodes, args)
    missed = unmet(seen, start)
    infinite = jnp.asarray(jnp.inf, dtype)
    state = _State(
        start._replace(
            dual=only_there(jax.tree.map(lambda s: settings.barrier / s, slacks(start)))
        ),
        jnp.asarray(settings.barrier, dtype),
        jnp.zeros((), dtype),
        10.0 * jnp.maximum(1.0, missed),
        seen.cost,
        missed,
        jnp.asarray(_RUNNING),
        jnp.asarray(0),
        infinite,
        infinite,
    )
    end = lax.while_loop(running, body, state)
    feasible = end.violation <= tolerance
    unfinished = jnp.where(feasible, Status.FEASIBLE, Status.ITERATION_LIMIT)
    stuck = (end.status == Status.INFEASIBLE) & feasible
    status = jnp.where(stuck, Status.FEASIBLE, end.status)
    nodes = end.point.nodes
    return InteriorSolution(
        jnp.concatenate([nodes.x, nodes.end[None]]),
        nodes.u,
        end.cost,
        jnp.where(status == _RUNNING, unfinished, status),
        end.violation,
        end.stationarity,
        end.point.rows,
        end.point.dual,
        end.iterations,
    )


def _first_point(
    program: StagedProgram,
    u: Array,
    states: Array,
    args: Any,
    settings: InteriorSettings,
    limits: tuple[Array, Array, Array, Array],
) -> _Point:
    """The start, pushed off the limits."""
    below, above, low, high = limits
    span = jnp.where(below & above, high - low, 1.0)
    u = jnp.where(below, jnp.maximum(u, low + _PUSH * span), u)
    u = jnp.where(above, jnp.minimum(u, high - _PUSH * span), u)
    nodes = Nodes(states[:-1], states[-1], u)
    found = values(program, nodes, args)
    nothing = jnp.zeros_like(u)
    return _Point(
        nodes,
        jnp.maximum(found.path, _PUSH),
        jnp.maximum(found.final, _PUSH),
        Bounded(jnp.zeros_like(found.path), jnp.zeros_like(found.final), nothing, nothing),
        jnp.zeros_like(program.final_rows(nodes.end, args)),
    )
