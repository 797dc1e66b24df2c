"""One pass of the interior-point method: a Newton step of the barrier problem, and its length.

See `interior_point` for the problem and the sources.
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

RUNNING = -1
"""The status of a start that has not ended."""
_LARGE_MULTIPLIER = 100.0
_SOLVED_TO = 10.0
"""A barrier problem counts as solved at this many times its barrier."""
_TO_BOUNDARY = 0.99
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


class Point(NamedTuple):
    """path, final : values that the inequalities are to take.  dual, rows : multipliers."""

    nodes: Nodes
    path: Array
    final: Array
    dual: Bounded
    rows: Array


class State(NamedTuple):
    """Between two passes.

    barrier, shift : ().  most : () of `unmet` that a trial may have.  cost, unmet : (), at the
    point.  status : () a `Status` or `RUNNING`.  violation, stationarity : () at the point before.
    """

    point: Point
    barrier: Array
    shift: Array
    most: Array
    cost: Array
    unmet: Array
    status: Array
    iterations: Array
    violation: Array
    stationarity: Array


class Limits(NamedTuple):
    """Of the controls, (N, b).  below, above : whether there is one.  low, high : 0 without."""

    below: Array
    above: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, program: StagedProgram, size: int, args: Any) -> Limits:
        """size : b."""
        lower, upper = limits_along(program, size, args)
        below, above = jnp.isfinite(lower), jnp.isfinite(upper)
        return cls(below, above, jnp.where(below, lower, 0.0), jnp.where(above, upper, 0.0))

    def slacks(self, point: Point) -> Bounded:
        """What is left to every limit; 1 where there is none."""
        u = point.nodes.u
        return Bounded(
            point.path,
            point.final,
            jnp.where(self.below, u - self.low, 1.0),
            jnp.where(self.above, self.high - u, 1.0),
        )

    def only_there(self, of: Bounded) -> Bounded:
        """Without limits that are infinite."""
        return of._replace(
            lower=jnp.where(self.below, of.lower, 0.0), upper=jnp.where(self.above, of.upper, 0.0)
        )


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


def unmet(found: Values, point: Point) -> Array:
    """Sum of the sizes of gaps, hard rows and excesses of the inequalities, ()."""
    excess = jnp.sum(jnp.abs(found.path - point.path))
    return found.unmet + excess + jnp.sum(jnp.abs(found.final - point.final))


def advanced(
    program: StagedProgram, limits: Limits, state: State, args: Any, settings: InteriorSettings
) -> State:
    """A start after one more pass.

    It judges the point that it is given, and moves on from there unless that was good enough.
    """
    dtype = state.cost.dtype
    tolerance = jnp.asarray(settings.tolerance, dtype)

    def merit(cost: Array, point: Point, barrier: Array) -> Array:
        logs = jax.tree.leaves(jax.tree.map(lambda s: jnp.sum(jnp.log(s)), limits.slacks(point)))
        return cost - barrier * sum(logs)

    def along(point: Point, step: Step, length: Array) -> Point:
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

    point = state.point
    slack, dual = limits.slacks(point), point.dual
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
        left = limits.only_there(jax.tree.map(lambda z, s: z * s - barrier, dual, slack))
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
    dual_step = limits.only_there(step.dual)
    share = jnp.maximum(_TO_BOUNDARY, 1.0 - barrier)
    longest = _to_boundary(slack, limits.only_there(step.slack), share)
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
    bounds = jax.tree.map(lambda s: barrier / s, limits.slacks(moved))
    kept = jax.tree.map(
        lambda z, b: jnp.clip(z, b / _DUAL_RANGE, b * _DUAL_RANGE), moved.dual, bounds
    )
    moved = moved._replace(dual=limits.only_there(kept))
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
            jnp.where(shift > _STUCK, Status.INFEASIBLE, RUNNING),
        ),
    )
    # The last pass only looks, so that what is said of the point returned is true of it.
    looking = state.iterations + 1 >= settings.max_iterations
    going = (status == RUNNING) & accepted & ~looking
    return State(
        jax.tree.map(lambda new, old: jnp.where(going, new, old), moved, point),
        barrier,
        shift,
        state.most,
        jnp.where(going, tried.cost, state.cost),
        jnp.where(going, tried.unmet, state.unmet),
        status,
        state.iterations + jnp.where(status == RUNNING, 1, 0),
        violation,
        stationarity,
    )
