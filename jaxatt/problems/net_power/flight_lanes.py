"""Flight of a block of intervals as one compiled program, lanes last inside, first outside.

A manoeuvre of any length is flown in blocks of one size, so that a new length compiles nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Vector, combination
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.problems.net_power.along_flight import AlongFlight
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.compilation import Routine
from jaxatt.simulation.dense_step import Dipole
from jaxatt.simulation.magnetic_action import HeldDipole, MomentumHold
from jaxatt.simulation.powered_flight import Carried, fly_interval
from jaxatt.simulation.powers import Powers
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.steering import Steering
from jaxatt.simulation.wheeled_body import WheeledBody, wheeled_body
from jaxatt.spacecraft.vehicle import Spacecraft

BLOCK = 32
"""Intervals in one compiled call."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Plant:
    """What flies: the same in all lanes.  hold : None where the dipoles are given, or zero."""

    powers: Powers
    torques: ExternalTorques
    hold: MomentumHold | None


class Row(NamedTuple):
    """Data of the intervals of a block, (lanes, BLOCK, ...) each.

    steering : as the steering asks for.  dipole : three components [A m^2], or () where it is
    not given.
    """

    steering: Any
    dipole: tuple[Any, ...]


def _begin(craft: Spacecraft, q_ib: Array, omega: Array, speeds: Array) -> Carried:
    """State before the first interval, lanes last, from (lanes, ...)."""
    body = wheeled_body(craft)
    motion = Motion(Quaternion.of(q_ib).normalized(), Vector.of(omega))
    return Carried(motion, body.spins(motion.omega, jnp.moveaxis(speeds, -1, 0)))


def _fly(
    plant: Plant, steering: Steering, carried: Carried, row: Row, around: AlongFlight, step: Array
) -> tuple[Carried, dict[str, Array]]:
    """Fly one block of intervals in all lanes; results, at the start of each, lead with the lanes.

    step : (lanes,) or (1,) [s], of a Runge-Kutta step.
    """
    body = wheeled_body(plant.powers.craft)

    def interval(at: Carried, inputs: Any) -> Any:
        (data, given), steps = inputs
        torque = steering(at.motion, data)
        action = _action(plant, given)
        after, spent = fly_interval(
            body, plant.torques, plant.powers, at, torque, action, steps, step
        )
        return after, (at, torque, spent)

    rows = jax.tree.map(lambda x: jnp.swapaxes(x, 0, 1), row)
    last, (nodes, torque, spent) = lax.scan(interval, carried, (rows, around.steps))
    return last, _at_nodes(plant, body, nodes, torque, rows.dipole, around) | {
        "wheel_torque": _lanes_first(torque, spent.solar),
        "solar": spent.solar.T,
        "wheels": spent.wheels.T,
        "magnetorquers": spent.magnetorquers.T,
        "lowest": _lanes_first(spent.lowest, spent.solar),
        "highest": _lanes_first(spent.highest, spent.solar),
        "strongest": _lanes_first(spent.strongest.parts, spent.solar),
    }


begin_lanes, fly_block = Routine(_begin), Routine(_fly)


def _action(plant: Plant, given: tuple[Array, ...]) -> Dipole:
    return plant.hold or HeldDipole(Vector(*given) if given else None)


def _at_nodes(
    plant: Plant,
    body: WheeledBody,
    nodes: Carried,
    torque: tuple[Array, ...],
    dipole: tuple[Array, ...],
    around: AlongFlight,
) -> dict[str, Array]:
    """Motion, dipole and powers at the start of each interval, lanes first."""
    motion, spins = nodes
    like = jnp.asarray(motion.omega.x)
    speeds = body.speeds(motion, spins)
    sun_b = motion.q_ib.rotate_inverse(_vector(around.sun))
    light = jnp.broadcast_to(around.light, like.shape)
    field = None if around.field is None else _vector(around.field)
    spun = combination(body.axes, spins, motion.omega)
    moment = _action(plant, dipole)(motion, spun, Along(field=field)) or 0.0 * motion.omega
    driven = plant.powers.wheels(torque, speeds) if torque else jnp.zeros_like(like)
    return {
        "q_ib": _lanes_first((motion.q_ib.eta, *motion.q_ib.eps.parts), like),
        "omega_ib": _lanes_first(motion.omega.parts, like),
        "omega_bw": _lanes_first(speeds, like),
        "dipole": _lanes_first(moment.parts, like),
        "light": light.T,
        "solar_power": (light * plant.powers.solar(sun_b)).T,
        "wheel_power": driven.T,
        "magnetorquer_power": plant.powers.magnetorquers(moment).T,
    }


def _vector(parts: Sequence[Floats]) -> Vector:
    x, y, z = (jnp.asarray(part) for part in parts)
    return Vector(x, y, z)


def _lanes_first(parts: Sequence[Any], like: Array) -> Array:
    """Components of (intervals, lanes) each as (lanes, intervals, components)."""
    if not parts:
        return jnp.zeros((*like.shape[::-1], 0))
    return jnp.stack([jnp.asarray(part).T for part in parts], axis=-1)
