"""Closed- or open-loop flight of the full model, wheel speeds included, with fine RK4 steps.

This is the judge of every answer: it shares no code with the roll-out that the optimiser uses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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

Law = Callable[[Array, AttitudeState, Environment], Array]
"""(interval, state, environment) -> (n,) [N m], wheel torques at one instant."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Trajectory:
    """A flight sampled at its nodes.

    q_ob : (..., nodes, 4).  omega_ob : (..., nodes, 3) [rad/s], relative to the orbit frame.
    omega_bw : (..., nodes, n) [rad/s].  omega_ib : (..., nodes, 3) [rad/s].
    wheel_torque : (..., nodes - 1, n) [N m], mean over each interval.
    """

    q_ob: Array
    omega_ob: Array
    omega_bw: Array
    omega_ib: Array
    wheel_torque: Array


def fly(craft: Spacecraft, start: AttitudeState, law: Law, table: EnvironmentTable) -> Trajectory:
    """Fly a control law through all intervals of `table`, feedback evaluated at every stage."""
    h = table.substep

    def shift(state: AttitudeState, rate: AttitudeState, time: Array | float) -> AttitudeState:
        return jax.tree.map(lambda x, dx: x + time * dx, state, rate)

    def substep(
        carry: tuple[AttitudeState, Array, Array], stages: Environment
    ) -> tuple[tuple[AttitudeState, Array, Array], None]:
        state, interval, impulse = carry

        def rate(point: AttitudeState, stage: int) -> tuple[AttitudeState, Array]:
            environment = jax.tree.map(lambda leaf: leaf[stage], stages)
            torque = law(interval, point, environment)
            return dynamics.derivative(craft, point, torque, environment), torque

        k1, t1 = rate(state, 0)
        k2, t2 = rate(shift(state, k1, h / 2), 1)
        k3, t3 = rate(shift(state, k2, h / 2), 2)
        k4, t4 = rate(shift(state, k3, h), 3)
        mean = jax.tree.map(lambda a, b, c, d: (a + 2 * b + 2 * c + d) / 6, k1, k2, k3, k4)
        end = shift(state, mean, h)
        end = AttitudeState(quaternion.normalize(end.q_ob), end.omega_ib, end.omega_bw)
        return (end, interval, impulse + h * (t1 + 2 * t2 + 2 * t3 + t4) / 6), None

    def interval_step(
        state: AttitudeState, inputs: tuple[Array, Environment]
    ) -> tuple[AttitudeState, tuple[AttitudeState, Array]]:
        interval, stages = inputs
        carry = (state, interval, jnp.zeros_like(state.omega_bw))
        (end, _, impulse), _ = lax.scan(substep, carry, stages)
        return end, (end, impulse / (h * stages.gradient.shape[0]))

    count = table.stages.gradient.shape[0]
    _, (states, torque) = lax.scan(interval_step, start, (jnp.arange(count), table.stages))
    nodes = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, states)
    omega_ob = dynamics.relative_rate(nodes, table.nodes)
    return Trajectory(nodes.q_ob, omega_ob, nodes.omega_bw, nodes.omega_ib, torque)


fly_law = jax.jit(fly)
"""`fly`, compiled, for a law that is a pytree of its own parameters."""


def fly_torque(
    craft: Spacecraft, start: AttitudeState, wheel_torque: Array, table: EnvironmentTable
) -> Trajectory:
    """Fly piecewise constant wheel torques, (N, n) [N m], and coast through the intervals left."""
    coast = table.stages.gradient.shape[0] - wheel_torque.shape[0]
    padded = jnp.concatenate([wheel_torque, jnp.zeros((coast, wheel_torque.shape[1]))])
    return fly(craft, start, lambda interval, state, environment: padded[interval], table)
