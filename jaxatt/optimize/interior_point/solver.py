"""Primal-dual interior-point method over stages, for one start; `jax.vmap` runs many.

    minimise    sum of cost(x_k, u_k) + terminal_cost(x_N)
    subject to  x_(k+1) = dynamics(x_k, u_k),  equality(x_k, u_k) = 0,  final_rows(x_N) = 0,
                lower <= u_k <= upper,  inequality(x_k, u_k) >= 0,  final_inequality(x_N) >= 0

over the controls, the states (multiple shooting) and those coordinates of the first state that the
programme leaves free.  A pass of the loop differentiates all stages twice, makes a Riccati
recursion for the Newton step of the barrier problem, and moves along it as far as the limits and a
filter allow.  Second derivatives are exact; where the reduced Hessian is not positive definite the
curvature is shifted until it is.  Hard rows enter with a large quadratic weight around
their multipliers, which is a tiny regularisation of the dual system that the next step corrects.

The end is a crossover (`crossover`): near enough to the solution, one step without a barrier
tells which limits hold, and full Newton steps with those limits as equations end quadratically.  A
limit is released where its multiplier turns negative and taken up where it is overstepped.  A
crossover that does not end in a few passes had the wrong limits; the start goes back to where it
began and follows the barrier on.

Sources: Waechter and Biegler (2006), "On the implementation of an interior-point filter line-search
algorithm for large-scale nonlinear programming", for barrier, shift and fraction to the boundary;
Vanroye, De Schutter and Decre (2023), "FATROP: a fast constrained optimal control problem solver
for robot trajectory optimization and control", for the Riccati recursion in such a method.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded, Nodes, values
from jaxatt.optimize.interior_point.newton_pass import PUSH, renewed, roomy
from jaxatt.optimize.interior_point.residuals import unmet
from jaxatt.optimize.interior_point.state import (
    RUNNING,
    Crossover,
    InteriorSettings,
    Limits,
    Place,
    Point,
    State,
)
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.status import Status

__all__ = [
    "InteriorSettings",
    "InteriorSolution",
    "State",
    "begin",
    "outcome",
    "running",
]


class InteriorSolution(NamedTuple):
    """Result of one start.

    x : (N + 1, s), states.  u : (N, b).  objective : ().  status : () a `Status`.
    violation : (), largest of gaps, hard rows and inequalities.  stationarity : (), largest of the
    Lagrangian's scaled gradient and the complementarity.  Both hold at the returned point, with
    exact derivatives.  rows : (r,), equality : (N, q) and dual : multipliers.  iterations : ()
    passes.
    """

    x: Array
    u: Array
    objective: Array
    status: Array
    violation: Array
    stationarity: Array
    rows: Array
    equality: Array
    dual: Bounded
    iterations: Array


def begin(
    program: OptimalControlProgram, u: Array, states: Array, args: Any, settings: InteriorSettings
) -> State:
    """State of a start before the first iteration.

    u : (N, b) and states : (N + 1, s), which need not obey the dynamics.
    """
    dtype = u.dtype
    limits = Limits.of(program, u.shape[1], args)
    start = _first_point(program, u, states, args, limits, settings)
    seen = values(program, start.nodes, args)
    missed = unmet(seen, start)
    infinite = jnp.asarray(jnp.inf, dtype)
    place = renewed(Place(start, seen.cost, missed), limits, settings)
    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, bool), start.dual)
    return State(
        place,
        Crossover(jnp.zeros((), int), nothing, place, jnp.asarray(settings.crossover_from, dtype)),
        jnp.asarray(settings.barrier, dtype),
        jnp.asarray(settings.shifts.begin, dtype),
        10.0 * jnp.maximum(1.0, missed),
        jnp.full((), RUNNING, int),
        jnp.zeros((), int),
        jnp.full((), settings.renewals, int),
        infinite,
        infinite,
    )


def running(state: State, settings: InteriorSettings) -> Array:
    """Whether a start still has iterations to do, ()."""
    return (state.status == RUNNING) & (state.iterations < settings.max_iterations)


def outcome(state: State, settings: InteriorSettings) -> InteriorSolution:
    """Result of a start from its final state."""
    feasible = state.violation <= settings.tolerance
    unfinished = jnp.where(feasible, Status.FEASIBLE, Status.ITERATION_LIMIT)
    stuck = (state.status == Status.INFEASIBLE) & feasible
    status = jnp.where(stuck, Status.FEASIBLE, state.status)
    point = state.place.point
    nodes = point.nodes
    return InteriorSolution(
        jnp.concatenate([nodes.x, nodes.end[None]]),
        nodes.u,
        state.place.cost,
        jnp.where(status == RUNNING, unfinished, status),
        state.violation,
        state.stationarity,
        point.rows,
        point.equality,
        point.dual,
        state.iterations,
    )


def _first_point(
    program: OptimalControlProgram,
    u: Array,
    states: Array,
    args: Any,
    limits: Limits,
    settings: InteriorSettings,
) -> Point:
    """Initial point, pushed off the limits."""
    below, above, low, high = limits
    span = jnp.where(below & above, high - low, 1.0)
    u = jnp.where(below, jnp.maximum(u, low + PUSH * span), u)
    u = jnp.where(above, jnp.minimum(u, high - PUSH * span), u)
    nodes = Nodes(states[:-1], states[-1], u)
    found = values(program, nodes, args)
    nothing = jnp.zeros_like(u)
    return Point(
        nodes,
        roomy(found.path, settings),
        roomy(found.final, settings),
        Bounded(jnp.zeros_like(found.path), jnp.zeros_like(found.final), nothing, nothing),
        jnp.zeros_like(program.final_equalities(nodes.end, args)),
        jnp.zeros_like(
            jax.vmap(lambda x, u, stage: program.equalities(x, u, stage, args))(
                nodes.x, u, program.stages(args)
            )
        ),
        jnp.zeros((u.shape[0] if settings.own_costates else 0, program.error_size), u.dtype),
    )
