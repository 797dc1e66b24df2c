"""Flight of a task of prescribed attitude: held, or turning at a constant rate while imaging."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.problems.net_power.along_flight import AlongFlight, along_flight, block_of, stacked
from jaxatt.problems.net_power.flight import AT_NODES, PoweredFlight, gathered
from jaxatt.problems.net_power.flight_lanes import BLOCK, Plant
from jaxatt.problems.net_power.flight_plant import common_intervals, common_plant
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import chunk_for, in_chunks
from jaxatt.runtime.compilation import Routine
from jaxatt.simulation.light_quadrature import parts_for
from jaxatt.simulation.magnetic_action import HeldDipole
from jaxatt.simulation.prescribed_turn import (
    Turned,
    Turning,
    begin_turn,
    turn_interval,
    turned_body,
)

LONGEST_STEP = 0.25
"""[s], of the integration: imaging turns by a fifth of a degree in it."""

_ROWS = 32
"""Tasks in one compiled call."""


def fly_held(manoeuvres: Sequence[Manoeuvre], rates: Any) -> PoweredFlight:
    """Fly tasks of one satellite and one number of intervals with prescribed attitudes.

    rates : (M, 3) [rad/s], in body axes, at which each body turns from its initial attitude on.
    A difference to the rate it starts with is taken up by the wheels at once.
    In what is returned the wheel torque of an interval is the one of the largest magnitude in it.
    """
    plant, count = common_plant(manoeuvres), common_intervals(manoeuvres)
    padded = BLOCK * (count // BLOCK + 1)  # one interval at least begins at the end
    steps = max(4, math.ceil(max(one.step for one in manoeuvres) / LONGEST_STEP - 1e-9))
    parts = parts_for(max(one.step for one in manoeuvres) / steps)

    def run(lanes: dict[str, Any]) -> dict[str, Floats]:
        which = lanes["of"].tolist()
        once = {k: along_flight(manoeuvres[k], padded, steps, parts) for k in dict.fromkeys(which)}
        around = stacked([once[k] for k in which])
        step = np.array([manoeuvres[k].step / steps for k in which])
        return _flown(plant, lanes, around, step, count)

    of = np.arange(len(manoeuvres))
    lanes = {
        "of": of,
        "rate": np.asarray(rates, float),
        "start": tuple(
            np.stack([np.asarray(getattr(one.start, name), float) for one in manoeuvres])
            for name in ("q_ib", "omega_ib", "omega_bw")
        ),
    }
    key = ("net-power hold", steps, parts, str(jax.tree.structure((plant, lanes))))
    found = in_chunks(run, lanes, min(_ROWS, chunk_for(len(of))), key=key)
    return gathered(manoeuvres, of, found)


def _flown(
    plant: Plant, lanes: dict[str, Any], around: AlongFlight, step: Floats, count: int
) -> dict[str, Floats]:
    """Fly one chunk block by block; `count` intervals and their last node are kept."""
    carried = _begin_lanes(plant, lanes["rate"], *lanes["start"])
    blocks = []
    for first in range(0, count + 1, BLOCK):
        place = block_of(around, first, BLOCK)
        carried, found = _turn_block(plant, carried, lanes["rate"], place, step)
        blocks.append(jax.tree.map(np.asarray, found))
    whole = {name: np.concatenate([one[name] for one in blocks], axis=1) for name in blocks[0]}
    return {name: x[:, : count + (name in AT_NODES)] for name, x in whole.items()}


def _begin(plant: Plant, rate: Array, q_ib: Array, omega: Array, speeds: Array) -> Turned:
    """State before the first interval, lanes last, from (lanes, ...)."""
    body = turned_body(plant.powers.craft)
    taken_up = body.inertia @ (Vector.of(omega) - Vector.of(rate))
    spinning = body.changed(tuple(jnp.moveaxis(jnp.asarray(speeds), -1, 0)), taken_up)
    return begin_turn(body, Quaternion.of(q_ib).normalized(), spinning)


def _turn(
    plant: Plant, carried: Turned, rate: Array, around: AlongFlight, step: Array
) -> tuple[Turned, dict[str, Array]]:
    """Fly one block of intervals in all lanes; results, at the start of each, lead with lanes."""
    body = turned_body(plant.powers.craft)
    turning = Turning(body, plant.torques, plant.hold or HeldDipole(), Vector.of(rate))

    def interval(at: Turned, steps: Any) -> Any:
        after, spent = turn_interval(turning, plant.powers, at, steps, step)
        return after, (at, spent)

    last, (nodes, spent) = lax.scan(interval, carried, around.steps)
    return last, _at_nodes(plant, turning, nodes, around) | {
        "wheel_torque": _lanes_first(spent.torque),
        "solar": spent.solar.T,
        "wheels": spent.wheels.T,
        "magnetorquers": spent.magnetorquers.T,
        "lowest": _lanes_first(spent.lowest),
        "highest": _lanes_first(spent.highest),
        "strongest": _lanes_first(spent.strongest.parts),
    }


_begin_lanes, _turn_block = Routine(_begin), Routine(_turn)


def _at_nodes(
    plant: Plant, turning: Turning, nodes: Turned, around: AlongFlight
) -> dict[str, Array]:
    """Motion, dipole and powers at the start of each interval, lanes first."""
    q_ib, speeds, momentum = nodes
    rate = turning.omega.map(lambda x: jnp.broadcast_to(x, jnp.shape(q_ib.eta)))
    rated = turning._replace(omega=rate)
    along = jax.tree.map(lambda x: x[:, 0, 0], around.steps.along)
    taken = turning.body.taken(rated.on_wheels(q_ib, momentum, along))
    moment = rated.moment(q_ib, momentum, along) or 0.0 * rate
    sun_b = q_ib.rotate_inverse(Vector(*(jnp.asarray(part) for part in around.sun)))
    return {
        "q_ib": _lanes_first((q_ib.eta, *q_ib.eps.parts)),
        "omega_ib": _lanes_first(rate.parts),
        "omega_bw": _lanes_first(speeds),
        "dipole": _lanes_first(moment.parts),
        "light": jnp.asarray(around.light).T,
        "solar_power": (jnp.asarray(around.light) * plant.powers.solar(sun_b)).T,
        "wheel_power": plant.powers.wheels(taken, speeds).T,
        "magnetorquer_power": plant.powers.magnetorquers(moment).T,
    }


def _lanes_first(parts: Sequence[Any]) -> Array:
    """Components of (intervals, lanes) each as (lanes, intervals, components)."""
    return jnp.stack([jnp.asarray(part).T for part in parts], axis=-1)
