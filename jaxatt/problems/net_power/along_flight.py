"""Surroundings of manoeuvres at every step of a fine flight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from jaxatt.attitude.components import Vector
from jaxatt.environment.along_orbit import evaluate
from jaxatt.environment.external import Along
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Satellite
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.light_quadrature import light_weights
from jaxatt.simulation.powered_flight import Step

_STAGES = np.array([0, 1, 1, 2])  # in half steps
_BLOCK = 4096  # instants of one evaluation


class AlongFlight(NamedTuple):
    """Surroundings of manoeuvres; last axis of lanes, one for each manoeuvre.

    steps : (intervals, steps, ..., lanes), as `Step`.  At the nodes (N + 1, lanes) of each, sun :
    components of the unit vector, light : visible fraction, field : components [T] or None.
    """

    steps: Step
    sun: tuple[Floats, ...]
    light: Floats
    field: tuple[Floats, ...] | None


def along_flight(manoeuvre: Manoeuvre, steps: int) -> AlongFlight:
    """Surroundings of one manoeuvre with so many steps an interval, without the axis of lanes."""
    satellite, count = manoeuvre.satellite, manoeuvre.intervals * steps
    step = manoeuvre.duration / count
    halves = manoeuvre.start_time + 0.5 * step * np.arange(2 * count + 1)
    along, sun, light = _surroundings(satellite, halves)
    shape = (manoeuvre.intervals, steps)
    stages = (2 * np.arange(count)[:, None] + _STAGES).reshape(*shape, 4)
    weights = light_weights(
        lambda times: _surroundings(satellite, times)[2], manoeuvre.start_time, step, count
    )
    middle = sun[1::2].reshape(*shape, 3)
    every = slice(None, None, 2 * steps)
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


_evaluated = jax.jit(evaluate, static_argnames="tidal")


def _surroundings(satellite: Satellite, times: Floats) -> tuple[Along, Floats, Floats]:
    """Along (n,) for the external torques, direction of the sun (n, 3) and its light (n,)."""
    count = len(times)
    fixed = np.asarray(satellite.light.sun, float)
    sun = np.broadcast_to(fixed / np.linalg.norm(fixed), (count, 3))
    if satellite.orbit is None:
        return Along(), sun, np.ones(count)
    block = min(_BLOCK, count)
    padded = np.pad(times, (0, -count % block), mode="edge")
    rows = [
        jax.tree.map(
            np.asarray,
            _evaluated(satellite.orbit, satellite.torques, satellite.gravity_gradient, row)[0],
        )
        for row in padded.reshape(-1, block)
    ]
    along = jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *rows)
    return along, sun, np.ones(count)
