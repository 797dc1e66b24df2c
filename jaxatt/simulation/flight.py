"""Simulation of the full model, wheel speeds included, open or closed loop, with fine RK4 steps.

This is the judge of every answer: it shares no code with the roll-out that the optimiser uses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude import quaternion
from jaxatt.environment.table import Environment, EnvironmentTable
from jaxatt.spacecraft import dynamics
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft

MINIMUM_SUBSTEPS = 20
"""Runge-Kutta steps an interval in a verification flight, at least."""

_RK4 = ((1 / 2, 1 / 6), (1 / 2, 1 / 3), (1.0, 1 / 3), (0.0, 1 / 6))
"""Of each stage: how far ahead the next one is, and the weight of its rate, both in steps."""

Law = Callable[[Array, AttitudeState, Environment], Array]
"""(interval, state, environment) -> (n + m,) [N m], torques of wheels and thrusters at one instant,
or of the wheels alone, (n,)."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Trajectory:
    """States and mean torques of a flight at its nodes.

    q_ob : (..., nodes, 4).  omega_ob : (..., nodes, 3) [rad/s], relative to the orbit frame.
    omega_bw : (..., nodes, n) [rad/s].  omega_ib : (..., nodes, 3) [rad/s].
    wheel_torque : (..., nodes - 1, n) [N m], mean over each interval.
    thrust : (..., nodes - 1, m) [N m], torque of each thruster, mean over each interval.
    fine : the same flight at every Runge-Kutta step, where something is watched between the nodes.
    """

    q_ob: Array
    omega_ob: Array
    omega_bw: Array
    omega_ib: Array
    wheel_torque: Array
    thrust: Array
    fine: Trajectory | None = None


Hold = Callable[[Array, AttitudeState, Environment, Any], tuple[Array, Any]]
"""(interval, state, environment, memory) -> torques held over the interval, and the new memory."""


def advance(
    craft: Spacecraft,
    state: AttitudeState,
    torque: Callable[[AttitudeState, Environment], Array],
    stages: Environment,
    h: Array,
) -> tuple[AttitudeState, Array]:
    """Advance the state by one RK4 step of h [s]; also return the mean torque (n + m,) [N m] in it.

    stages : the environment at the four stage times, leading axis 4.
    """

    def stage(
        carry: tuple[AttitudeState, AttitudeState, Array], inputs: tuple[Array, Environment]
    ) -> tuple[tuple[AttitudeState, AttitudeState, Array], None]:
        (point, end, mean), ((ahead, weight), environment) = carry, inputs
        asked = torque(point, environment)
        asked = jnp.pad(asked, (0, craft.actuators - asked.shape[0]))
        rate = dynamics.derivative(craft, point, asked, environment)
        point = jax.tree.map(lambda x, dx: x + ahead * h * dx, state, rate)
        end = jax.tree.map(lambda x, dx: x + weight * h * dx, end, rate)
        return (point, end, mean + weight * asked), None

    # A loop and not four copies of the dynamics: a quarter of the program to compile.
    nothing = jnp.zeros(craft.actuators, state.omega_ib.dtype)
    (_, end, mean), _ = lax.scan(stage, (state, state, nothing), (jnp.asarray(_RK4), stages))
    return AttitudeState(quaternion.normalize(end.q_ob), end.omega_ib, end.omega_bw), mean


def _interval(
    craft: Spacecraft,
    state: AttitudeState,
    torque: Callable[[AttitudeState, Environment], Array],
    stages: Environment,
    h: Array,
) -> tuple[AttitudeState, Array]:
    """Advance the state by one interval, whose `stages` lead with (S, 4); also return its mean
    torque.
    """

    def substep(
        carry: tuple[AttitudeState, Array], along: Environment
    ) -> tuple[tuple[AttitudeState, Array], None]:
        end, mean = advance(craft, carry[0], torque, along, h)
        return (end, carry[1] + mean), None

    nothing = jnp.zeros(craft.actuators, state.omega_ib.dtype)
    (end, total), _ = lax.scan(substep, (state, nothing), stages)
    return end, total / stages.gradient.shape[0]


def trajectory(
    craft: Spacecraft,
    start: AttitudeState,
    states: AttitudeState,
    torque: Array,
    table: EnvironmentTable,
) -> Trajectory:
    """Assemble a trajectory from the start, the later states and the mean torques (K, n + m)."""
    nodes = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, states)
    omega_ob = dynamics.relative_rate(nodes, table.nodes)
    count = craft.wheels.count
    return Trajectory(
        nodes.q_ob, omega_ob, nodes.omega_bw, nodes.omega_ib, torque[:, :count], torque[:, count:]
    )


def at_nodes(fine: Trajectory, every: int) -> Trajectory:
    """Sample flights (S, ...) at every so many of their steps, and keep all steps as `fine`."""

    def mean(torque: Array) -> Array:
        *lanes, steps, size = torque.shape
        return torque.reshape(*lanes, steps // every, every, size).mean(axis=-2)

    return Trajectory(
        fine.q_ob[..., ::every, :],
        fine.omega_ob[..., ::every, :],
        fine.omega_bw[..., ::every, :],
        fine.omega_ib[..., ::every, :],
        mean(fine.wheel_torque),
        mean(fine.thrust),
        fine,
    )


def fly(craft: Spacecraft, start: AttitudeState, law: Law, table: EnvironmentTable) -> Trajectory:
    """Simulate a control law through all intervals of `table`, with feedback at every RK4 stage."""

    def step(
        state: AttitudeState, inputs: tuple[Array, Environment]
    ) -> tuple[AttitudeState, tuple[AttitudeState, Array]]:
        interval, stages = inputs
        end, mean = _interval(
            craft, state, lambda x, along: law(interval, x, along), stages, table.substep
        )
        return end, (end, mean)

    count = table.stages.gradient.shape[0]
    _, (states, torque) = lax.scan(step, start, (jnp.arange(count), table.stages))
    return trajectory(craft, start, states, torque, table)


def fly_held(
    craft: Spacecraft, start: AttitudeState, law: Hold, memory: Any, table: EnvironmentTable
) -> Trajectory:
    """Simulate a law that is evaluated once an interval and held; `memory` is passed on."""

    def step(
        carry: tuple[AttitudeState, Any], inputs: tuple[Array, Environment]
    ) -> tuple[tuple[AttitudeState, Any], tuple[AttitudeState, Array]]:
        (state, known), (interval, stages) = carry, inputs
        first = jax.tree.map(lambda leaf: leaf[0, 0], stages)
        held, known = law(interval, state, first, known)
        end, mean = _interval(craft, state, lambda x, along: held, stages, table.substep)
        return (end, known), (end, mean)

    count = table.stages.gradient.shape[0]
    inputs = (jnp.arange(count), table.stages)
    _, (states, torque) = lax.scan(step, (start, memory), inputs)
    return trajectory(craft, start, states, torque, table)


fly_law = jax.jit(fly)
"""`fly`, compiled, for a law that is a pytree of its own parameters."""

fly_held_law = jax.jit(fly_held)
"""`fly_held`, compiled, for a law that is a pytree of its own parameters."""


def fly_torque(
    craft: Spacecraft, start: AttitudeState, torque: Array, table: EnvironmentTable
) -> Trajectory:
    """Simulate piecewise constant torques of wheels and thrusters, (N, n + m) [N m], then coast.

    The thrusters' columns may be left out.
    """
    coast = table.stages.gradient.shape[0] - torque.shape[0]
    padded = jnp.concatenate([torque, jnp.zeros((coast, torque.shape[1]))])
    return fly(craft, start, lambda interval, state, environment: padded[interval], table)
