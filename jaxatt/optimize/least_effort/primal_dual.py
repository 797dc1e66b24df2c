"""Primal-dual method for the least sum of magnitudes that satisfies some rows within limits.

    minimise    sum e_k sqrt((E u_k)^2 + s^2)  +  1/2 sum of w r^2 over the soft rows
    subject to  r(u) = 0 for the hard rows,  |l u_k| <= 1 at every stage k

Newton steps on the conditions for a minimum, with the limits behind a barrier that vanishes and a
dual variable for every magnitude, which makes the steps converge fast where the smoothing s is
small and the optimum has corners.  The blocks of the stages are eliminated first, so a step solves
one system as large as the number of rows, whatever the number of stages.  The curvature of the
rows is left out, as in a Gauss-Newton method.

Sources: Chan, Golub and Mulet (1999), "A nonlinear primal-dual method for total variation-based
image restoration"; Nocedal and Wright (2006), chapter 19.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.augmented_lagrangian.outer import LARGE_MULTIPLIER, Schedule
from jaxatt.optimize.augmented_lagrangian.solver import Multipliers
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.small_systems import invert_spd_blocks, solve_spd
from jaxatt.optimize.solution import Solution
from jaxatt.optimize.solver import Solver
from jaxatt.optimize.status import RUNNING, Status

_INSIDE = 0.95
_TO_BOUNDARY = 0.995
_BARRIER = 1e-2
_BARRIER_FACTOR = 0.2
_CURVATURE_SHARE = 0.02
"""Of the curvature that majorises a magnitude, at least kept: away from zero the true one vanishes
and, where several controls could do the same, nothing else would bound the step."""
_LARGEST_STEP = 2.0
_SHRINKS = 0.9
_MOST_STALLS = 25
_HOPELESS_MULTIPLIER = 1e8
_DAMPING = 1e-12
_TINY = 1e-300


class _State(NamedTuple):
    u: Array
    sign: Array
    rows: Array
    limits: Array
    smoothing: Array
    barrier: Array
    status: Array
    iterations: Array
    stationarity: Array
    violation: Array
    least: Array
    stalls: Array


def _longest(value: Array, step: Array) -> Array:
    """Longest step up to 1 that keeps value + step non-negative, nearly."""
    ratio = jnp.where(step < 0.0, -_TO_BOUNDARY * value / jnp.minimum(step, -_TINY), 1.0)
    return jnp.minimum(1.0, jnp.min(ratio, initial=1.0))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class LeastEffort(Solver):
    """Minimise the effort of a `RootProgram`; a start is its controls, (N, b), near a root.

    schedule : its tolerances, smoothing and largest number of iterations are used.

    CONVERGED is tested at the point that is returned, with the smoothing's end and the exact
    derivatives.
    """

    schedule: Schedule

    name = "least effort"
    supports = frozenset(
        {
            features.ROWS_AT_ONCE,
            features.MAGNITUDE_LIMITS,
            features.COUNTED_APART,
            features.EFFORT,
        }
    )
    needs = frozenset({features.ROWS_AT_ONCE, features.MAGNITUDE_LIMITS, features.EFFORT})
    batch_axis = 0
    passes = 16

    def init(self, program: RootProgram, start: Array, args: Any) -> _State:
        """State of a start, moved within the limits."""
        limits, effort_map, effort_scale = _effort(program, args)
        faces = jnp.concatenate([limits, -limits])
        u, dtype = start * program.free(args), start.dtype
        over = jnp.max(jnp.abs(u @ limits.T), axis=1, keepdims=True)
        u = u / jnp.maximum(1.0, over / _INSIDE)
        parts = u @ effort_map.T
        smoothing = jnp.asarray(self.schedule.smoothing_start, dtype)
        barrier = jnp.asarray(_BARRIER, dtype) * jnp.max(effort_scale)
        infinite = jnp.asarray(jnp.inf, dtype)
        return _State(
            u,
            0.9 * parts / jnp.sqrt(parts**2 + smoothing**2),
            jnp.zeros(program.row_weight(args).shape, dtype),
            barrier / (1.0 - u @ faces.T),
            smoothing,
            barrier,
            jnp.asarray(RUNNING),
            jnp.asarray(0),
            infinite,
            infinite,
            infinite,
            jnp.asarray(0),
        )

    def step(self, program: RootProgram, state: _State, args: Any) -> _State:
        """Take a Newton step on the optimality conditions with a barrier."""
        limits, effort_map, effort_scale = _effort(program, args)
        schedule, free, row_weight = self.schedule, program.free(args), program.row_weight(args)
        dtype, size = state.u.dtype, state.u.shape[1]
        faces = jnp.concatenate([limits, -limits])
        hard = jnp.isinf(row_weight)
        compliance = jnp.where(hard, 0.0, 1.0 / row_weight)
        eye = jnp.eye(size, dtype=dtype)[None]
        fixed = eye * (1.0 - free)[:, :, None]

        assert program.response is not None
        rows, jacobian = program.response(state.u, args)
        jacobian = jacobian * free[:, None]
        room = 1.0 - state.u @ faces.T
        parts = state.u @ effort_map.T
        length = jnp.sqrt(parts**2 + state.smoothing**2)
        slope = effort_scale * (parts / length) @ effort_map

        pulled = jnp.einsum("kmi,m->ki", jacobian, state.rows)
        gradient = (slope + pulled + state.limits @ faces) * free
        largest = jnp.maximum(jnp.max(jnp.abs(state.rows)), jnp.max(state.limits))
        stationarity = jnp.max(jnp.abs(gradient)) / jnp.maximum(1.0, largest / LARGE_MULTIPLIER)
        stationarity = jnp.maximum(stationarity, jnp.max(room * state.limits))
        soft = jnp.max(jnp.where(hard, 0.0, jnp.abs(rows - compliance * state.rows)))
        stationarity = jnp.maximum(stationarity, soft)
        violation = jnp.max(jnp.where(hard, jnp.abs(rows), 0.0))
        small = state.smoothing <= schedule.smoothing_end * (1.0 + 1e-9)
        feasible = violation <= schedule.tolerance
        converged = small & feasible & (stationarity <= schedule.stationarity)
        finite = jnp.isfinite(violation) & jnp.isfinite(stationarity)
        shrunk = feasible | (violation <= _SHRINKS * state.least)
        stalls = jnp.where(shrunk, 0, state.stalls + 1)
        hopeless = (stalls >= _MOST_STALLS) | (~feasible & (largest > _HOPELESS_MULTIPLIER))
        unfinished = jnp.where(feasible, Status.FEASIBLE, Status.ITERATION_LIMIT)
        unfinished = jnp.where(hopeless, Status.INFEASIBLE, unfinished)
        last = (state.iterations >= schedule.max_iterations) | hopeless
        status = jnp.where(
            ~finite,
            Status.NOT_FINITE,
            jnp.where(converged, Status.CONVERGED, jnp.where(last, unfinished, RUNNING)),
        )

        bent = 1.0 - state.sign * parts / length
        curvature = effort_scale * jnp.maximum(bent, _CURVATURE_SHARE) / length
        blocks = jnp.einsum("kq,qi,qj->kij", curvature, effort_map, effort_map)
        blocks = blocks + jnp.einsum("kf,fi,fj->kij", state.limits / room, faces, faces)
        blocks = blocks * free[:, :, None] * free[:, None] + fixed + _DAMPING * eye
        inverse = invert_spd_blocks(blocks)
        push = (slope + (state.barrier / room) @ faces) * free
        spread = jnp.einsum("kij,kmj->kmi", inverse, jacobian)
        matrix = jnp.einsum("kmi,kni->mn", jacobian, spread)
        diagonal = jnp.diagonal(matrix) * _DAMPING + _TINY + compliance
        missing = rows - jnp.einsum("kmi,ki->m", spread, push)
        shares = solve_spd(matrix + jnp.diag(diagonal), missing)
        step = -jnp.einsum("kij,kj->ki", inverse, push) - jnp.einsum("kmi,m->ki", spread, shares)
        step = step * free

        towards = step @ faces.T
        limits_step = (state.barrier + state.limits * towards) / room - state.limits
        sign_step = (parts + bent * (step @ effort_map.T)) / length - state.sign
        ahead = jnp.minimum(
            _longest(room, -towards), _LARGEST_STEP / jnp.maximum(jnp.max(jnp.abs(step)), _TINY)
        )
        ahead = jnp.minimum(1.0, ahead)
        shrinks = ahead > 0.5
        moved = _State(
            state.u + ahead * step,
            state.sign
            + sign_step
            * jnp.minimum(
                _longest(1.0 - state.sign, -sign_step), _longest(1.0 + state.sign, sign_step)
            ),
            shares,
            state.limits + limits_step * _longest(state.limits, limits_step),
            jnp.where(
                shrinks,
                jnp.maximum(schedule.smoothing_end, schedule.smoothing_factor * state.smoothing),
                state.smoothing,
            ),
            jnp.where(
                shrinks,
                jnp.maximum(0.1 * schedule.stationarity, _BARRIER_FACTOR * state.barrier),
                state.barrier,
            ),
            status,
            state.iterations + 1,
            stationarity,
            violation,
            jnp.minimum(state.least, violation),
            stalls,
        )
        ended = state._replace(status=status, stationarity=stationarity, violation=violation)
        return jax.tree.map(lambda new, old: jnp.where(status == RUNNING, new, old), moved, ended)

    def done(self, state: _State) -> Array:
        """Whether the start has converged or given up."""
        return state.status != RUNNING

    def result(self, program: RootProgram, state: _State, args: Any) -> Solution:
        """Result with the effort at the last smoothing."""
        _, effort_map, effort_scale = _effort(program, args)
        smoothing = self.schedule.smoothing_end
        effort = jnp.sqrt((state.u @ effort_map.T) ** 2 + smoothing**2)
        return Solution(
            state.u,
            jnp.sum(effort_scale * (effort - smoothing)),
            state.status,
            state.violation,
            state.stationarity,
            Multipliers(state.rows, jnp.zeros((0,), state.u.dtype), state.limits),
            state.iterations,
        )


def _effort(program: RootProgram, args: Any) -> tuple[Array, Array, Array]:
    """Limits (l, b), map (q, b) and scale (N, 1) or (1, 1) of the effort."""
    assert program.limits is not None
    assert program.effort_map is not None and program.effort_scale is not None
    scale = jnp.atleast_1d(program.effort_scale(args))[:, None]
    return program.limits(args), program.effort_map(args), scale
