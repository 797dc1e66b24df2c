"""Flight of a chunk of manoeuvres as one compiled program, lanes last inside, first outside."""

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
from jaxatt.simulation.magnetic_action import HeldDipole, MomentumHold
from jaxatt.simulation.powered_flight import Interval, begin, fly_interval
from jaxatt.simulation.powers import Powers
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.steering import Steering
from jaxatt.simulation.wheeled_body import WheeledBody, wheeled_body


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Plant:
    """What flies: the same in all lanes.  hold : None where the dipoles are given, or zero."""

    powers: Powers
    torques: ExternalTorques
    hold: MomentumHold | None


def _fly(
    plant: Plant, steering: Steering, lanes: dict[str, Any], around: AlongFlight, step: Array
) -> dict[str, Array]:
    """Fly all lanes of a chunk; results lead with the lanes."""
    craft = plant.powers.craft
    body = wheeled_body(craft)
    q_ib, omega, speeds = (jnp.asarray(part) for part in lanes["start"])
    motion = Motion(Quaternion.of(q_ib).normalized(), Vector.of(omega))
    rows, dipole = jax.tree.map(lambda x: jnp.swapaxes(x, 0, 1), (lanes["rows"], lanes["dipole"]))
    started = begin(body, motion, jnp.moveaxis(speeds, -1, 0))

    def interval(carried: Any, inputs: Any) -> Any:
        row, given, steps = inputs
        torque = steering(carried.motion, row)
        action = plant.hold or HeldDipole(Vector(*given) if given else None)
        after, left = fly_interval(
            body, plant.torques, plant.powers, carried, torque, action, steps, step
        )
        return after, (left, torque)

    last, (series, torque) = lax.scan(interval, started, (rows, dipole, around.steps))
    nodes = _at_nodes(motion, speeds, series)
    return _series(plant, body, nodes, torque, dipole, around) | {
        "torque": _lanes_first(torque),
        "solar": series.solar.T,
        "wheels": series.wheels.T,
        "magnetorquers": series.magnetorquers.T,
        "fastest": _lanes_first(last.fastest),
        "strongest": _lanes_first(last.strongest.parts),
    }


fly_lanes = Routine(_fly)


class _Nodes(NamedTuple):
    """Motion and wheel speeds at the nodes, (N + 1, lanes) each."""

    motion: Motion
    speeds: tuple[Array, ...]


def _at_nodes(start: Motion, speeds: Array, series: Interval) -> _Nodes:
    first = _Nodes(start, tuple(jnp.moveaxis(speeds, -1, 0)))
    rest = _Nodes(series.motion, series.speeds)
    return jax.tree.map(lambda x, later: jnp.concatenate([x[None], later]), first, rest)


def _series(
    plant: Plant,
    body: WheeledBody,
    nodes: _Nodes,
    torque: tuple[Array, ...],
    dipole: tuple[Array, ...],
    around: AlongFlight,
) -> dict[str, Array]:
    """What is known at the nodes, lanes first; torques and dipoles last as in the last interval."""
    motion, speeds = nodes
    like = jnp.asarray(motion.omega.x)
    sun_b = motion.q_ib.rotate_inverse(_vector(around.sun))
    light = jnp.broadcast_to(around.light, like.shape)
    held = tuple(jnp.concatenate([t, t[-1:]]) for t in torque)
    given = tuple(jnp.concatenate([m, m[-1:]]) for m in dipole)
    action = plant.hold or HeldDipole(Vector(*given) if given else None)
    spun = combination(body.axes, body.spins(motion.omega, jnp.asarray(speeds)), motion.omega)
    field = None if around.field is None else _vector(around.field)
    moment = action(motion, spun, Along(field=field)) or 0.0 * motion.omega
    nothing = jnp.zeros_like(like)
    return {
        "q_ib": _lanes_first((motion.q_ib.eta, *motion.q_ib.eps.parts)),
        "omega_ib": _lanes_first(motion.omega.parts),
        "omega_bw": _lanes_first(speeds, like),
        "dipole": _lanes_first(moment.parts),
        "light": light.T,
        "solar_power": (light * plant.powers.solar(sun_b)).T,
        "wheel_power": (plant.powers.wheels(held, speeds) if held else nothing).T,
        "magnetorquer_power": plant.powers.magnetorquers(moment).T,
    }


def _vector(parts: Sequence[Floats]) -> Vector:
    x, y, z = (jnp.asarray(part) for part in parts)
    return Vector(x, y, z)


def _lanes_first(parts: Sequence[Any], like: Array | None = None) -> Array:
    """Components of (nodes, lanes) or (lanes,) as (lanes, nodes, components)."""
    if not parts:
        assert like is not None
        return jnp.zeros((*like.shape[::-1], 0))
    return jnp.stack([jnp.asarray(part).T for part in parts], axis=-1)
