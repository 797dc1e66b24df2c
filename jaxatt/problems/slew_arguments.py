"""The numbers of a slew for the solver, from what it is asked to do."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.environment.table import EnvironmentTable
from jaxatt.problems.hands_off import SparseArguments
from jaxatt.problems.mounting import Mounting
from jaxatt.problems.pointing import NO_POINTING, PointingPath
from jaxatt.problems.slew import RATE_SCALE, SlewForm, SlewParameters
from jaxatt.problems.slew_case import Aim, Passage
from jaxatt.problems.task import Flags, Floats, Goal
from jaxatt.simulation.momentum_model import BodyParameters
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft, total_momentum


def _nearer(q: Floats, to: Floats) -> Floats:
    """The sign of an attitude q that the short way from another leads to."""
    return q * (1.0 if float(q @ to) >= 0 else -1.0)


def slew_parameters(
    craft: Spacecraft,
    mounting: Mounting,
    start: AttitudeState,
    table: EnvironmentTable,
    aim: Aim,
    passage: Passage | None,
    step: float,
    form: SlewForm,
    pointing: PointingPath = NO_POINTING,
) -> SlewParameters:
    """Parameters of a slew from a state at the first node of a table.

    pointing : cones and rate limits that are enforced.
    """
    wheels, m = craft.wheels, mounting
    begin = np.asarray(start.q_ob)
    reference = _nearer(np.asarray(aim.q_ob), begin)
    waypoint = reference if passage is None else _nearer(np.asarray(passage.q_ob), begin)
    q_ib = quaternion.multiply(table.nodes.orbit_attitude[0], start.q_ob)
    momentum = total_momentum(craft, start.omega_ib, start.omega_bw)
    inverse_inertia = jnp.linalg.inv(jnp.asarray(craft.inertia_without_spin))
    return SlewParameters(
        body=BodyParameters(jnp.asarray(craft.inertia), inverse_inertia),
        table=table,
        start=jnp.concatenate([q_ib, start.omega_ib]),
        momentum=momentum if form.propelled else quaternion.rotate(q_ib, momentum),
        reference=jnp.asarray(reference),
        reference_rate=jnp.asarray(aim.omega_ob),
        waypoint=jnp.asarray(waypoint),
        waypoint_node=jnp.asarray(1 if passage is None else passage.node),
        to_body=jnp.asarray(m.to_body * m.scale),
        to_external=jnp.asarray(m.to_external * m.scale),
        to_wheels=jnp.asarray(m.to_wheel * m.scale / np.asarray(wheels.torque_limit)[:, None]),
        lower=jnp.asarray(m.lower),
        upper=jnp.asarray(m.upper),
        step=jnp.asarray(step),
        wheel_speed=jnp.asarray(start.omega_bw),
        wheel_axes=jnp.asarray(wheels.axes),
        wheel_inertia=jnp.asarray(wheels.inertia),
        wheel_torque=jnp.asarray(m.to_wheel * m.scale),
        speed_limit=jnp.asarray(wheels.speed_limit),
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
    """Arguments of the sparse programme.

    weight : (N,), h_k.  forbidden : (N,), intervals without torque.
    axes : "body" or "wheels", the axes of the decision variables.
    """
    m, scale = mounting, mounting.scale
    effort_map = m.to_body * scale / scale.max()
    if form.propelled:
        # Each actuator pays for itself: the torques of opposed thrusters must not cancel.
        pushes = np.abs(m.to_body + m.to_external).sum(axis=0)
        effort_map = np.diag(pushes * scale / scale.max())
    elif axes == "wheels":
        # The null space of the mounting turns nothing; a little cost keeps it still.
        effort_map = np.concatenate([effort_map, 1e-3 * np.eye(len(scale))])
    w = goal.weights
    rows = [w.attitude / 4.0] * 3 + [2.0 * w.rate / RATE_SCALE**2] * 3
    rows += [w.waypoint / 4.0] * (3 if form.has_waypoint else 0)
    soft = goal.terminal == "penalty"
    free = np.where(np.asarray(forbidden, bool)[:, None], 0.0, np.ones((1, len(scale))))
    return SparseArguments(
        plant=plant,
        weight=jnp.asarray(weight),
        free=jnp.asarray(free),
        count_scale=jnp.asarray(1.0),
        effort_scale=jnp.asarray(0.0),
        effort_map=jnp.asarray(effort_map),
        row_weight=jnp.asarray(rows if soft else np.full(len(rows), np.inf)),
    )
