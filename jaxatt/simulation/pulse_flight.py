"""Simulation of valves that open and shut at exact times inside the intervals.

Every interval is cut at its switching times and on an even grid besides; each piece is one
Runge-Kutta step of constant torque, so that no step ever straddles a switch.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.environment.table import Environment, EnvironmentTable
from jaxatt.simulation.flight import MINIMUM_SUBSTEPS, Trajectory, advance, trajectory
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft

_STAGE_TIMES = (0.0, 0.5, 0.5, 1.0)


def _half_steps(table: EnvironmentTable) -> Environment:
    """Environment on the grid of half substeps, leading axes (N, 2 S + 1)."""

    def grid(leaf: Array) -> Array:
        at = jnp.asarray(leaf)
        inner = at[:, :, :2].reshape(at.shape[0], -1, *at.shape[3:])
        return jnp.concatenate([inner, at[:, -1:, 3]], axis=1)

    return jax.tree.map(grid, table.stages)


def _at(along: Environment, place: Array) -> Environment:
    """Environment between grid points, at a place in half substeps from the interval's start."""
    last = along.gradient.shape[0] - 2
    index = jnp.clip(jnp.floor(place).astype(int), 0, last)
    share = place - index
    return jax.tree.map(lambda leaf: (1.0 - share) * leaf[index] + share * leaf[index + 1], along)


def fly_pulses(
    craft: Spacecraft,
    start: AttitudeState,
    wheel_torque: Array,
    opens: Array,
    shuts: Array,
    table: EnvironmentTable,
    pieces: int = MINIMUM_SUBSTEPS,
) -> Trajectory:
    """Simulate constant wheel torques and one opening a thruster in each interval, then coast.

    wheel_torque : (N, n) [N m].  opens, shuts : (N, m) [s] from the interval's start, equal where
    a valve stays shut; an open thruster gives its limit.
    pieces : even cuts of every interval, besides those where a valve switches (static).
    """
    count = table.stages.gradient.shape[0]
    half = 0.5 * table.substep
    length = table.substep * table.stages.gradient.shape[1]
    coast = count - opens.shape[0]
    tail = ((0, coast), (0, 0))
    limit = jnp.asarray(craft.thrusters.torque_limit)
    even = jnp.linspace(0.0, 1.0, pieces + 1) * length

    def piece(
        carry: tuple[AttitudeState, Array],
        inputs: tuple[Array, Array],
        along: Environment,
        row: tuple[Array, Array, Array],
    ) -> tuple[tuple[AttitudeState, Array], None]:
        (state, impulse), (first, h) = carry, inputs
        wheel, opened, shut = row
        middle = first + 0.5 * h
        thrust = jnp.where((opened <= middle) & (middle < shut), limit, 0.0)
        torque = jnp.concatenate([wheel, thrust])
        times = first + jnp.asarray(_STAGE_TIMES) * h
        stages = jax.vmap(lambda time: _at(along, time / half))(times)
        state, mean = advance(craft, state, lambda x, environment: torque, stages, h)
        return (state, impulse + h * mean), None

    def interval(
        state: AttitudeState, inputs: tuple[Environment, Array, Array, Array]
    ) -> tuple[AttitudeState, tuple[AttitudeState, Array]]:
        along, wheel, opened, shut = inputs
        edges = jnp.sort(jnp.concatenate([even, opened, shut]))
        carry = (state, jnp.zeros(craft.actuators, state.omega_ib.dtype))
        (end, impulse), _ = lax.scan(
            lambda c, e: piece(c, e, along, (wheel, opened, shut)),
            carry,
            (edges[:-1], jnp.diff(edges)),
        )
        return end, (end, impulse / length)

    wheel, opened, shut = (jnp.pad(part, tail) for part in (wheel_torque, opens, shuts))
    _, (states, torque) = lax.scan(interval, start, (_half_steps(table), wheel, opened, shut))
    return trajectory(craft, start, states, torque, table)
