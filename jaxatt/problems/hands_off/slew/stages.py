"""The slew as an optimal-control programme, interval by interval.

A state holds q_ib (4), omega_ib (3) [rad/s] and, where external torques act, the total momentum
in inertial axes (3) [N m s]; where wheel speeds are limited, the impulse of every control (b) [s]
since the first node as well, from which the speeds follow.  Errors of the attitude are turns in
body axes, four modified Rodrigues parameters long: smooth up to a full turn from the reference.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.environment.table import Environment
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.problems.hands_off.slew.derivatives import slew_derivatives
from jaxatt.problems.hands_off.slew.model import (
    SlewForm,
    SlewParameters,
    inertial_reference,
    inertial_waypoint,
    range_margins,
    rate_row,
)
from jaxatt.problems.hands_off.slew.pointing_path import node_margins
from jaxatt.problems.hands_off.sparse_program import SparseArguments
from jaxatt.problems.terminal_rows import attitude_row, attitude_rows
from jaxatt.simulation import momentum_model


class SlewStage(NamedTuple):
    """Data of one interval.

    along : Environment (S, 4), `down` in place of the orbit's attitude.  node : () int.
    directions : (m, 3), those of the cones at its first node, inertial.
    """

    along: Environment
    node: Array
    directions: Array


def _wheel_speeds(x: Array, p: SlewParameters) -> Array:
    """Wheel speeds (n,) [rad/s], by the integral of (4.20d) as in `model.wheel_speeds`."""
    impulse = x[x.shape[0] - p.wheel_torque.shape[1] :]
    driven = jnp.sum(p.wheel_torque * impulse[None], axis=1) / p.wheel_inertia
    carried = jnp.sum(p.wheel_axes * (x[4:7] - p.start[4:7])[:, None], axis=0)
    return p.wheel_speed + driven - carried


def _speed_margins(x: Array, p: SlewParameters) -> Array:
    return jnp.concatenate(range_margins(_wheel_speeds(x, p), p))


@functools.cache
def slew_stages(form: SlewForm, size: int) -> OptimalControlProgram:
    """Programme of a slew with `size` controls an interval, without a cost.

    The waypoint is an equality whose weight is zero at all other nodes.
    """
    carried = 10 if form.disturbed else 7

    def start(args: SparseArguments) -> Array:
        p = args.plant
        parts = [p.start, p.momentum] if form.disturbed else [p.start]
        if form.speed_limited:
            parts.append(jnp.zeros(size, p.start.dtype))
        return jnp.concatenate(parts)

    def stages(args: SparseArguments) -> SlewStage:
        along = momentum_model.with_down(args.plant.table.stages)
        count = along.gradient.shape[0]
        toward = args.plant.pointing.directions if form.pointed else jnp.zeros((count + 1, 0, 3))
        return SlewStage(along, jnp.arange(count), toward[:-1])

    def dynamics(x: Array, u: Array, stage: SlewStage, args: SparseArguments) -> Array:
        p = args.plant
        torque = tuple(sum(p.to_body[i, j] * u[j] for j in range(size)) for i in range(3))
        momentum = tuple(p.momentum[i] for i in range(3))
        state = tuple(x[i] for i in range(carried))
        end = momentum_model.step(
            state, momentum, torque, stage.along, p.table.substep, p.body, form.disturbed
        )
        if not form.speed_limited:
            return jnp.stack(end)
        return jnp.concatenate([jnp.stack(end), x[carried:] + p.step * u])

    def waypoint(x: Array, u: Array, stage: SlewStage, args: SparseArguments) -> Array:
        return attitude_row(inertial_waypoint(args.plant), x[:4])

    def waypoint_weight(stage: SlewStage, args: SparseArguments) -> Array:
        return jnp.where(stage.node == args.plant.waypoint_node, args.row_weight[-3:], 0.0)

    def path(x: Array, directions: Array, p: SlewParameters) -> Array:
        parts = [_speed_margins(x, p)] if form.speed_limited else []
        if form.pointed:
            parts.append(node_margins(x[:4], x[4:7], directions, p.step, p.pointing.limits))
        return jnp.concatenate(parts)

    def margins(x: Array, u: Array, stage: SlewStage, args: SparseArguments) -> Array:
        found = path(x, stage.directions, args.plant)
        return jnp.where(stage.node == 0, 1.0, found)  # nothing changes the first node

    def final_margins(x: Array, args: SparseArguments) -> Array:
        return path(x, args.plant.pointing.directions[-1], args.plant)

    def final_rows(x: Array, args: SparseArguments) -> Array:
        p, q = args.plant, x[:4]
        rows = [attitude_rows(inertial_reference(p), q, p.held), rate_row(q, x[4:7], p)]
        if form.has_waypoint:
            rows.append(attitude_row(inertial_waypoint(p), q))
        return jnp.concatenate(rows)

    def final_weight(args: SparseArguments) -> Array:
        if not form.has_waypoint:
            return args.row_weight
        count = args.plant.table.nodes.gradient.shape[0] - 1
        last = jnp.where(args.plant.waypoint_node == count, args.row_weight[-3:], 0.0)
        return jnp.concatenate([args.row_weight[:-3], last])

    program = OptimalControlProgram(
        start=start,
        stages=stages,
        dynamics=dynamics,
        cost=lambda x, u, stage, args, smoothing: jnp.zeros((), x.dtype),
        curvature=lambda x, u, stage, args, smoothing: jnp.zeros(
            (x.shape[0] - 1 + size, x.shape[0] - 1 + size), x.dtype
        ),
        error_size=carried - 1 + (size if form.speed_limited else 0),
        retract=retract,
        difference=difference,
        final_rows=final_rows,
        final_weight=final_weight,
        linearise=None if form.gyroscopic else slew_derivatives(form),
    )
    if form.has_waypoint:
        program = replace(program, equality=waypoint, equality_weight=waypoint_weight)
    if form.path_limited:
        program = replace(program, inequality=margins, final_inequality=final_margins)
    return program
