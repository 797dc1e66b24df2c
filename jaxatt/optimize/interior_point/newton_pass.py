"""One iteration of the interior-point method: Newton step, line search, updates.

See `interior_point` for the problem and the sources.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.interior_point.crossover import (
    Pairs,
    active_after,
    active_along,
    active_pairs,
    barrier_pairs,
)
from jaxatt.optimize.interior_point.model import Bounded, Duals, Nodes, model, values
from jaxatt.optimize.interior_point.residuals import Residuals, residuals, unmet, unmet_at
from jaxatt.optimize.interior_point.state import (
    RUNNING,
    Crossover,
    InteriorSettings,
    Limits,
    Place,
    Point,
    State,
)
from jaxatt.optimize.interior_point.step import Step, newton_step
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.status import Status

_SOLVED_TO = 10.0
"""A barrier problem counts as solved at this many times its barrier."""
_TO_BOUNDARY = 0.99
_SHORTER = 0.3
_MOST_TRIALS = 4
_PROGRESS = 1e-4
_NEGLIGIBLE = 1e-7
_DUAL_RANGE = 1e10
_STUCK = 1e8
_TINY = 1e-300
_SHORT = 1e-7
"""Length of a step that leads nowhere, where a start may be renewed."""
PUSH = 1e-2
"""Share of its range by which a start is kept off a limit; least slack of a start."""
_NEAR = 0.03
"""Error of a barrier problem from which the crossover is tried."""
_STIFFER = 4.0
"""Growth of the regularisation from one settling pass to the next."""
_CROSSOVER_PASSES = 8
"""Passes of a crossover; one that takes longer has the wrong limits and comes to nothing."""


class _Search(NamedTuple):
    """Outcome of a line search.

    trials : () made.  place : where the step ends, with the multipliers of before.
    """

    trials: Array
    length: Array
    place: Place
    accepted: Array


def _where(which: Array, new: Any, old: Any) -> Any:
    return jax.tree.map(lambda a, b: jnp.where(which, a, b), new, old)


def _to_boundary(value: Bounded, step: Bounded, share: Array) -> Array:
    """Fraction-to-boundary rule: longest step up to 1 that leaves 1 - share of every value."""

    def of(v: Array, dv: Array) -> Array:
        ratio = jnp.where(dv < 0.0, -share * v / jnp.minimum(dv, -_TINY), 1.0)
        return jnp.min(ratio, initial=1.0)

    lengths = jax.tree.leaves(jax.tree.map(of, value, step))
    return jnp.min(jnp.stack(lengths))


def _lowered(barrier: Array, found: Residuals, settings: InteriorSettings) -> Array:
    """Next barrier parameter: smaller once the current barrier problem is solved."""
    for _ in range(2):
        lower = jnp.minimum(settings.factor * barrier, barrier**settings.power)
        least = jnp.minimum(barrier, 0.1 * jnp.asarray(settings.tolerance, barrier.dtype))
        solved = found.error(barrier) <= _SOLVED_TO * barrier
        barrier = jnp.where(solved, jnp.maximum(least, lower), barrier)
    return barrier


def advanced(
    program: OptimalControlProgram,
    limits: Limits,
    state: State,
    args: Any,
    settings: InteriorSettings,
) -> State:
    """State of a start after one more iteration.

    It judges the point that it is given, and moves on from there unless that was good enough.
    """
    place, crossover = state.place, state.crossover
    point = place.point
    slack, dual = limits.slacks(point), point.dual
    dtype = slack.lower.dtype
    tolerance = jnp.asarray(settings.tolerance, dtype)
    penalty = jnp.asarray(settings.row_penalty, dtype)

    found = model(
        program,
        point.nodes,
        Duals(point.equality, point.rows, dual.path, dual.final),
        args,
        point.costates if settings.own_costates else None,
    )
    far = residuals(found, point, slack, program.free_start)
    violation, stationarity = far.violation, far.stationarity()
    finite = jnp.isfinite(violation) & jnp.isfinite(stationarity)
    converged = (violation <= tolerance) & (stationarity <= tolerance) & (far.excess <= tolerance)

    waiting = (crossover.left == 0) & (state.barrier <= crossover.below) & (state.shift == 0.0)
    beginning = waiting & (far.error(state.barrier) <= _NEAR)
    left = jnp.where(beginning, _CROSSOVER_PASSES, crossover.left)
    crossing_over = left > 0
    barrier = jnp.where(crossing_over, state.barrier, _lowered(state.barrier, far, settings))
    pairs: Pairs = _where(
        crossing_over & ~beginning,
        active_pairs(crossover.active, slack, dual, penalty),
        barrier_pairs(slack, dual, jnp.where(beginning, 0.0, barrier)),
    )
    shift = jnp.where(crossing_over, 0.0, state.shift)
    step = newton_step(
        found, slack, dual, pairs, penalty, program.free_start, shift, program.integrals
    )
    step = step._replace(slack=limits.only_there(step.slack), dual=limits.only_there(step.dual))
    share = jnp.maximum(_TO_BOUNDARY, 1.0 - barrier)
    longest = jnp.where(crossing_over, 1.0, _to_boundary(slack, step.slack, share))
    search = _searched(program, limits, state, step, barrier, longest, crossing_over, args)
    accepted = search.accepted
    if settings.renewals:
        accepted = accepted & (crossing_over | (search.length > _SHORT))
    dual_length = jnp.where(crossing_over, 1.0, _to_boundary(dual, step.dual, share))
    moved = search.place.point._replace(
        dual=jax.tree.map(lambda z, dz: z + dual_length * dz, dual, step.dual),
        rows=point.rows + search.length * step.rows,
        equality=point.equality + search.length * step.equality,
    )
    if settings.own_costates:
        turned = step.costates - point.costates
        moved = moved._replace(costates=point.costates + search.length * turned)
    active = _where(
        beginning,
        active_along(slack, dual, step.slack, step.dual),
        active_after(crossover.active, limits.slacks(moved), moved.dual),
    )
    moved = _kept(limits, moved, barrier, crossing_over)

    # A model that is not convex, or a step that leads nowhere, asks for more curvature.
    by = settings.shifts
    more = jnp.maximum(by.first, jnp.where(state.shift > 0.0, by.growth * state.shift, 0.0))
    less = jnp.where(state.shift < by.least, 0.0, state.shift / by.shrink)
    if settings.settling:
        settling = state.iterations >= settings.max_iterations - settings.settling
        less = jnp.where(settling, _STIFFER * jnp.maximum(state.shift, by.first), less)
    shift = jnp.where(crossing_over, state.shift, jnp.where(accepted, less, more))
    stopped, left_over, most = shift > _STUCK, state.renewals, state.most
    onward = _where(accepted, search.place._replace(point=moved), place)
    if settings.renewals:
        again = stopped & (left_over > 0)
        left_over = left_over - again
        stopped, shift = stopped & ~again, jnp.where(again, 0.0, shift)
        barrier = jnp.where(again, settings.barrier, barrier)
        roomier = place.point._replace(
            path=roomy(found.path, settings), final=roomy(found.final, settings)
        )
        beginning_anew = Place(roomier, place.cost, unmet_at(found, roomier))
        most = jnp.where(again, 10.0 * jnp.maximum(1.0, beginning_anew.unmet), most)
        onward = _where(again, renewed(beginning_anew, limits, settings), onward)
    stuck = jnp.where(stopped, Status.INFEASIBLE, RUNNING)
    status = jnp.where(finite | crossing_over, stuck, Status.NOT_FINITE)
    status = jnp.where(converged, Status.CONVERGED, status).astype(state.status.dtype)
    # The last pass only looks, so that what is said of the point returned is true of it.
    looking = state.iterations + 1 >= settings.max_iterations
    going = (status == RUNNING) & ~looking
    failed = crossing_over & (~accepted | ~finite | (left == 1))
    anchor = _where(beginning, place, crossover.anchor)
    onward = _where(failed, anchor, onward)
    return State(
        _where(going, onward, place),
        Crossover(
            jnp.where(crossing_over & ~failed, left - 1, 0),
            active,
            anchor,
            jnp.where(beginning, 0.5 * state.barrier, crossover.below),
        ),
        barrier,
        shift,
        most,
        status,
        state.iterations + jnp.where(status == RUNNING, 1, 0),
        left_over,
        violation,
        stationarity,
    )


def _searched(
    program: OptimalControlProgram,
    limits: Limits,
    state: State,
    step: Step,
    barrier: Array,
    longest: Array,
    crossing_over: Array,
    args: Any,
) -> _Search:
    """Choose the step length by a filter; the crossover takes full steps."""
    place, nodes = state.place, state.place.point.nodes

    def merit(cost: Array, point: Point) -> Array:
        logs = jax.tree.leaves(jax.tree.map(lambda s: jnp.sum(jnp.log(s)), limits.slacks(point)))
        return cost - barrier * sum(logs)

    def along(length: Array) -> Point:
        return place.point._replace(
            nodes=Nodes(
                jax.vmap(program.retract)(nodes.x, length * step.x),
                program.retract(nodes.end, length * step.end),
                nodes.u + length * step.u,
            ),
            path=place.point.path + length * step.slack.path,
            final=place.point.final + length * step.slack.final,
        )

    merit_now = merit(place.cost, place.point)

    def attempt(before: _Search) -> _Search:
        length = jnp.where(before.trials == 0, longest, _SHORTER * before.length)
        point = along(length)
        seen = values(program, point.nodes, args)
        miss, cost = unmet(seen, point), merit(seen.cost, point)
        nearer = miss <= (1.0 - 10.0 * _PROGRESS * length) * place.unmet
        cheaper = cost <= merit_now - _PROGRESS * jnp.minimum(place.unmet, 1.0)
        level = (miss <= _NEGLIGIBLE) & (cost <= merit_now + 1e-10 * jnp.abs(merit_now))
        good = (miss <= state.most) & (nearer | cheaper | level) & jnp.isfinite(cost)
        good = (crossing_over | good) & jnp.isfinite(miss)
        return _Search(before.trials + 1, length, Place(point, seen.cost, miss), good)

    def rejected(tried: _Search) -> Array:
        return ~(tried.accepted | (tried.trials >= _MOST_TRIALS))

    none = _Search(jnp.asarray(0), longest, place, ~step.convex)
    tried = lax.while_loop(rejected, attempt, none)
    return tried._replace(accepted=tried.accepted & step.convex)


def roomy(values: Array, settings: InteriorSettings) -> Array:
    """Slacks of inequalities with these values, at least a little.

    Where starts may be renewed, one that is violated gets as much slack as it misses, which does
    not cut the first steps short.
    """
    return jnp.maximum(jnp.abs(values) if settings.renewals else values, PUSH)


def renewed(place: Place, limits: Limits, settings: InteriorSettings) -> Place:
    """The same place with the multipliers of the first barrier, and none of the hard rows."""
    point = place.point
    point = point._replace(
        rows=jnp.zeros_like(point.rows),
        equality=jnp.zeros_like(point.equality),
    )
    dual = jax.tree.map(lambda s: settings.barrier / s, limits.slacks(point))
    return place._replace(point=point._replace(dual=limits.only_there(dual)))


def _kept(limits: Limits, point: Point, barrier: Array, crossing_over: Array) -> Point:
    """Keep multipliers near those of the barrier; in the crossover, nothing below zero."""

    def near(z: Array, s: Array) -> Array:
        return jnp.clip(z, barrier / s / _DUAL_RANGE, barrier / s * _DUAL_RANGE)

    pair = point.dual, limits.slacks(point)
    dual = _where(
        crossing_over,
        jax.tree.map(lambda z: jnp.maximum(z, 0.0), point.dual),
        jax.tree.map(near, *pair),
    )
    return limits.within(point._replace(dual=limits.only_there(dual)))
