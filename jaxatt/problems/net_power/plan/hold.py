"""Flight of a task of prescribed attitude: held, or turning at a constant rate while imaging."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.problems.net_power.along_flight import AlongFlight, along_flight, stacked
from jaxatt.problems.net_power.flight import PoweredFlight, gathered, plant_of
from jaxatt.problems.net_power.flight_lanes import Plant
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import chunk_for, in_chunks
from jaxatt.runtime.compilation import Routine
from jaxatt.simulation.magnetic_action import HeldDipole
from jaxatt.simulation.prescribed_turn import (
    TurnedBody,
    Turning,
    TurnInterval,
    begin_turn,
    turn_interval,
    turned_body,
)

LONGEST_STEP = 0.25
"""[s], of the integration: imaging turns by a fifth of a degree in it."""

_ROWS = 32
_LENGTH = 128
"""Numbers of intervals are rounded up to multiples of it, so that tasks share a program."""


def fly_held(manoeuvres: Sequence[Manoeuvre], rates: Floats) -> PoweredFlight:
    """Fly tasks of one satellite and one number of intervals with prescribed attitudes.

    rates : (M, 3) [rad/s], in body axes, at which each body turns from its initial attitude on.
    A difference to the rate it starts with is taken up by the wheels at once.
    In what is returned the wheel torque of an interval is where it was largest.
    """
    count = manoeuvres[0].intervals
    longer = [_lengthened(one) for one in manoeuvres]
    steps = max(4, math.ceil(max(one.step for one in longer) / LONGEST_STEP - 1e-9))
    plant = plant_of(longer[0])

    def run(lanes: dict[str, Any]) -> Any:
        which = lanes["of"].tolist()
        once = {k: along_flight(longer[k], steps) for k in dict.fromkeys(which)}
        step = np.array([longer[k].step / steps for k in which])
        return _fly_lanes(plant, lanes, stacked([once[k] for k in which]), step)

    of = np.arange(len(longer))
    names = ("q_ib", "omega_ib", "omega_bw")
    lanes = {
        "of": of,
        "rate": np.asarray(rates, float),
        "start": tuple(
            np.stack([np.asarray(getattr(one.start, name), float) for one in longer])
            for name in names
        ),
    }
    key = ("net-power hold", longer[0].intervals, steps, jax.tree.structure((plant, lanes)))
    found = in_chunks(run, lanes, min(_ROWS, chunk_for(len(of))), key=key)
    return gathered(manoeuvres, of, _shortened(found, count))


def _lengthened(manoeuvre: Manoeuvre) -> Manoeuvre:
    intervals = -(-manoeuvre.intervals // _LENGTH) * _LENGTH
    return dataclasses.replace(manoeuvre, intervals=intervals, duration=intervals * manoeuvre.step)


def _shortened(found: dict[str, Floats], count: int) -> dict[str, Floats]:
    """Series of the first `count` intervals, and the extremes of speeds and dipoles over them."""
    most = ("fastest", "strongest")
    nodes = {"q_ib", "omega_ib", "omega_bw", "dipole", "light"}
    nodes |= {name for name in found if name.endswith("_power")}
    return {
        name: values[:, : count + 1] if name in nodes else values[:, :count]
        for name, values in found.items()
        if name not in most
    } | {name: found[name][:, :count].max(axis=1) for name in most}


def _fly(plant: Plant, lanes: dict[str, Any], around: AlongFlight, step: Array) -> dict[str, Array]:
    """Fly all lanes of a chunk; results lead with the lanes."""
    body = turned_body(plant.powers.craft)
    q, omega, speeds = (jnp.asarray(part) for part in lanes["start"])
    rate = Vector.of(lanes["rate"])
    turning = Turning(body, plant.torques, plant.hold or HeldDipole(), rate)
    taken_up = body.inertia @ (Vector.of(omega) - rate)
    spinning = body.changed(tuple(jnp.moveaxis(speeds, -1, 0)), taken_up)
    started = begin_turn(body, Quaternion.of(q).normalized(), spinning)

    def interval(carried: Any, steps: Any) -> Any:
        return turn_interval(turning, plant.powers, carried, steps, step)

    _, series = lax.scan(interval, started, around.steps)
    nodes = TurnInterval(
        *jax.tree.map(
            lambda x, later: jnp.concatenate([x[None], later]),
            (started.q_ib, started.speeds),
            (series.q_ib, series.speeds),
        ),
        *series[2:],
    )
    return _series(plant, turning, body, nodes, around) | {
        "torque": _lanes_first(series.torque),
        "solar": series.solar.T,
        "wheels": series.wheels.T,
        "magnetorquers": series.magnetorquers.T,
        "fastest": _lanes_first(series.fastest),
        "strongest": _lanes_first(series.strongest.parts),
    }


_fly_lanes = Routine(_fly)


def _series(
    plant: Plant, turning: Turning, body: TurnedBody, nodes: TurnInterval, around: AlongFlight
) -> dict[str, Array]:
    """What is known at the nodes, lanes first."""
    q_ib, speeds = nodes.q_ib, nodes.speeds
    like = jnp.asarray(q_ib.eta)
    rate = turning.omega.map(lambda x: jnp.broadcast_to(x, like.shape))
    at_nodes = turning._replace(omega=rate)
    momentum = body.momentum(speeds, rate)
    # An interval's first stage is at its first node.
    along = jax.tree.map(lambda x: jnp.concatenate([x[:, 0, 0], x[-1:, -1, 3]]), around.steps.along)
    moment = at_nodes.moment(q_ib, momentum, along) or 0.0 * rate
    light = jnp.broadcast_to(around.light, like.shape)
    torque = at_nodes.on_wheels(q_ib, momentum, along)
    taken = tuple(jnp.asarray(share.dot(torque)) for share in body.shares)
    sun = Vector(*(jnp.asarray(x) for x in around.sun))
    return {
        "q_ib": _lanes_first((q_ib.eta, *q_ib.eps.parts)),
        "omega_ib": _lanes_first(rate.parts),
        "omega_bw": _lanes_first(speeds),
        "dipole": _lanes_first(moment.parts),
        "light": light.T,
        "solar_power": (light * plant.powers.solar(q_ib.rotate_inverse(sun))).T,
        "wheel_power": plant.powers.wheels(taken, speeds).T,
        "magnetorquer_power": plant.powers.magnetorquers(moment).T,
    }


def _lanes_first(parts: Sequence[Any]) -> Array:
    """Components of (nodes, lanes) or (lanes,) as (lanes, nodes, components)."""
    return jnp.stack([jnp.asarray(part).T for part in parts], axis=-1)
