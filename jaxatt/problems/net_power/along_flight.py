"""Surroundings of manoeuvres at every step of a fine flight."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from jaxatt.attitude.components import Vector
from jaxatt.environment.along_orbit import evaluate
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Satellite
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.light_quadrature import light_weights
from jaxatt.simulation.powered_flight import Step

_STAGES = np.array([0, 1, 1, 2])  # in half steps
_BLOCK = 4096  # instants of one evaluation


class AlongFlight(NamedTuple):
    """Surroundings of manoeuvres; last axis of lanes, one for each manoeuvre.

    steps : (intervals, steps, ..., lanes), as `Step`.  At the start (intervals, lanes) of each,
    sun : components of the unit vector, light : visible fraction, field : components [T] or None.
    """

    steps: Step
    sun: tuple[Floats, ...]
    light: Floats
    field: tuple[Floats, ...] | None


def along_flight(manoeuvre: Manoeuvre, intervals: int, steps: int) -> AlongFlight:
    """Surroundings of one manoeuvre, without the axis of lanes.

    intervals : how many of its intervals, from the first on; those after its end go on.
    steps : Runge-Kutta steps an interval.
    """
    satellite, count = manoeuvre.satellite, intervals * steps
    step = manoeuvre.step / steps
    halves: Floats = manoeuvre.start_time + 0.5 * step * np.arange(2.0 * count + 1.0)
    along, sun, light = _surroundings(satellite, halves)
    shape = (intervals, steps)
    stages = (2 * np.arange(count)[:, None] + _STAGES).reshape(*shape, 4)
    weights = light_weights(
        lambda times: sunlight_at(satellite, times)[1], manoeuvre.start_time, step, count
    )
    middle = sun[1::2].reshape(*shape, 3)
    every = slice(0, -1, 2 * steps)
    field = along.field
    return AlongFlight(
        Step(
            jax.tree.map(lambda leaf: np.asarray(leaf)[stages], along),
            Vector(*np.moveaxis(middle, -1, 0)),
            weights.reshape(*shape, 4),
        ),
        tuple(sun[every].T),
        light[every],
        None if field is None else tuple(np.asarray(part)[every] for part in field.parts),
    )


def stacked(parts: Sequence[AlongFlight]) -> AlongFlight:
    """Surroundings of several manoeuvres, one lane each."""
    together: AlongFlight = jax.tree.map(lambda *leaves: np.stack(leaves, axis=-1), *parts)
    return together


def block_of(around: AlongFlight, first: int, count: int) -> AlongFlight:
    """Surroundings of some intervals, from `first` on."""
    block: AlongFlight = jax.tree.map(lambda leaf: leaf[first : first + count], around)
    return block


_evaluated = jax.jit(evaluate, static_argnames="tidal")


def sunlight_at(satellite: Satellite, times: Floats) -> tuple[Floats, Floats]:
    """Unit vector (n, 3) to the sun in inertial axes, and the exact share (n,) of its light.

    times : (n,) [s] since the epoch of the orbit.
    """
    if satellite.orbit is None:
        return _without_orbit(satellite, len(times))
    along = _blockwise(satellite, times, surroundings=False)
    assert along.sun is not None and along.light is not None
    return np.asarray(along.sun.array), np.asarray(along.light)


def _surroundings(satellite: Satellite, times: Floats) -> tuple[Along, Floats, Floats]:
    """Along (n,) for the external torques, and `sunlight_at`."""
    if satellite.orbit is None:
        return Along(), *_without_orbit(satellite, len(times))
    along = _blockwise(satellite, times, surroundings=True)
    assert along.sun is not None and along.light is not None
    direction, light = np.asarray(along.sun.array), np.asarray(along.light)
    if satellite.torques.solar_pressure is None:
        along = along._replace(sun=None, light=None)
    if float(satellite.orbit.sine) == 0.0:
        along = along._replace(disturbance=None)
    return along, direction, light


def _without_orbit(satellite: Satellite, count: int) -> tuple[Floats, Floats]:
    if satellite.light.sun is None:
        raise ValueError(
            "light: a satellite without an orbit has no date, so its sun must be fixed; give the "
            "direction of the sun in inertial axes, or an orbit"
        )
    fixed = np.asarray(satellite.light.sun, float)
    return np.broadcast_to(fixed / np.linalg.norm(fixed), (count, 3)), np.ones(count)


def _blockwise(satellite: Satellite, times: Floats, surroundings: bool) -> Along:
    """Along (n,) in blocks of one compiled size; without `surroundings`, sun and light alone."""
    assert satellite.orbit is not None
    orbit = satellite.orbit if surroundings else dataclasses.replace(satellite.orbit, field=None)
    torques = satellite.torques if surroundings else ExternalTorques()
    tidal = satellite.gravity_gradient and surroundings
    count = len(times)
    padded = np.pad(times, (0, -count % _BLOCK), mode="edge")
    rows = [
        jax.tree.map(np.asarray, _evaluated(orbit, torques, tidal, row, satellite.light)[0])
        for row in padded.reshape(-1, _BLOCK)
    ]
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *rows)
