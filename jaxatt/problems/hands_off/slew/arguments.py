"""Arguments of a slew's programme, computed from its description."""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.environment.table import Environment, EnvironmentTable
from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters
from jaxatt.problems.hands_off.slew.mounting import Mounting
from jaxatt.problems.hands_off.sparse_program import SparseArguments
from jaxatt.problems.hands_off.task import Goal
from jaxatt.problems.manoeuvre import Target, Waypoint
from jaxatt.problems.pointing.cones import NO_POINTING, PointingPath
from jaxatt.problems.terminal_rows import RATE_SCALE
from jaxatt.problems.wheel_speeds import speed_range
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.simulation.momentum_model import BodyParameters
from jaxatt.spacecraft.dynamics import AttitudeState, at_relative_rate
from jaxatt.spacecraft.vehicle import Spacecraft, total_momentum


class Beginning(NamedTuple):
    """State and momentum at the beginning of a slew.

    state : at the first node.  q_ib : (4,), attitude of the body relative to inertial axes.
    momentum, momentum_i : (3,) [N m s], total momentum in body and in inertial axes.
    """

    state: AttitudeState
    q_ib: Array
    momentum: Array
    momentum_i: Array


def _from_orbit(
    craft: Spacecraft, q_ob: Array, omega_ob: Array, omega_bw: Array, environment: Environment
) -> Beginning:
    """Beginning from attitude and rate relative to the orbit, and wheel speeds."""
    state = at_relative_rate(q_ob, omega_ob, omega_bw, environment)
    q_ib = quaternion.multiply(environment.orbit_attitude, state.q_ob)
    momentum = total_momentum(craft, state.omega_ib, state.omega_bw)
    return Beginning(state, q_ib, momentum, quaternion.rotate(q_ib, momentum))


_begun = Routine(_from_orbit, options=RUNS_ONCE)


def begin(
    craft: Spacecraft, q_ob: Floats, omega_ob: Floats, omega_bw: Floats, environment: Environment
) -> Beginning:
    """As `_from_orbit`, on no device in particular: a program that was kept leaves it on one."""
    found: Beginning = jax.tree.map(
        lambda leaf: jax.device_put(np.asarray(leaf)),
        _begun(craft, q_ob, omega_ob, omega_bw, environment),
    )
    return found


def _nearer(q: Floats, to: Floats) -> Floats:
    """The quaternion q or -q that is nearer to another one."""
    return q * (1.0 if float(q @ to) >= 0 else -1.0)


def slew_parameters(
    craft: Spacecraft,
    mounting: Mounting,
    beginning: Beginning,
    table: EnvironmentTable,
    target: Target,
    waypoint: Waypoint | None,
    step: float,
    form: SlewForm,
    pointing: PointingPath = NO_POINTING,
) -> SlewParameters:
    """Parameters of a slew that begins at the first node of a table.

    pointing : cones and rate limits that are enforced.
    """
    wheels, m = craft.wheels, mounting
    start, first = beginning.state, np.asarray(beginning.state.q_ob)
    reference = _nearer(np.asarray(target.q_ob), first)
    passed = reference if waypoint is None else _nearer(np.asarray(waypoint.q_ob), first)
    inverse_inertia = np.linalg.inv(np.asarray(craft.inertia_without_spin))
    slowest, fastest = speed_range(wheels, start.omega_bw, every_band=True)
    # Not jnp.asarray, which compiles a program for each shape.
    return SlewParameters(
        body=BodyParameters(jax.device_put(craft.inertia), jax.device_put(inverse_inertia)),
        table=table,
        start=jax.device_put(np.concatenate([beginning.q_ib, start.omega_ib])),
        momentum=beginning.momentum if form.has_thrusters else beginning.momentum_i,
        reference=jax.device_put(reference),
        reference_rate=jax.device_put(target.omega_ob),
        held=jax.device_put(target.held),
        waypoint=jax.device_put(passed),
        waypoint_node=jax.device_put(1 if waypoint is None else waypoint.node),
        to_body=jax.device_put(m.to_body * m.scale),
        to_external=jax.device_put(m.to_external * m.scale),
        to_wheels=jax.device_put(m.to_wheel * m.scale / np.asarray(wheels.torque_limit)[:, None]),
        lower=jax.device_put(m.lower),
        upper=jax.device_put(m.upper),
        step=jax.device_put(step),
        wheel_speed=jax.device_put(start.omega_bw),
        wheel_axes=jax.device_put(wheels.axes),
        wheel_inertia=jax.device_put(wheels.inertia),
        wheel_torque=jax.device_put(m.to_wheel * m.scale),
        speed_lower=jax.device_put(slowest),
        speed_upper=jax.device_put(fastest),
        pointing=pointing,
    )


def slew_arguments(
    plant: SlewParameters,
    mounting: Mounting,
    goal: Goal,
    weight: Floats,
    forbidden: Flags,
    form: SlewForm,
    axes: str,
) -> SparseArguments:
    """Arguments of the sparse programme of a slew.

    weight : (N,), h_k.  forbidden : (N,), intervals without torque.
    axes : "body" or "wheels", the axes of the decision variables.
    """
    m, scale = mounting, mounting.scale
    effort_map = m.to_body * scale / scale.max()
    if form.has_thrusters:
        # Each actuator pays for itself: the torques of opposed thrusters must not cancel.
        pushes = np.abs(m.to_body + m.to_external).sum(axis=0)
        effort_map = np.diag(pushes * scale / scale.max())
    elif axes == "wheels":
        # The null space of the mounting turns nothing; a little cost keeps it still.
        effort_map = np.concatenate([effort_map, 1e-3 * np.eye(len(scale))])
    w = goal.weights
    rows = [w.attitude / 4.0] * plant.held.shape[0] + [2.0 * w.rate / RATE_SCALE**2] * 3
    rows += [w.waypoint / 4.0] * (3 if form.has_waypoint else 0)
    soft = goal.terminal == "penalty"
    free = np.where(np.asarray(forbidden, bool)[:, None], 0.0, np.ones((1, len(scale))))
    return SparseArguments(
        plant=plant,
        weight=jax.device_put(weight),
        free=jax.device_put(free),
        count_scale=jax.device_put(1.0),
        effort_scale=jax.device_put(0.0),
        price=jax.device_put(np.ones(len(weight))),
        effort_map=jax.device_put(effort_map),
        row_weight=jax.device_put(rows if soft else np.full(len(rows), np.inf)),
    )
