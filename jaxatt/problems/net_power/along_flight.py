"""Surroundings of manoeuvres at every step of a fine flight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from jaxatt.attitude.components import Vector
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at, surroundings_at
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.light_quadrature import light_weights
from jaxatt.simulation.powered_flight import Step

_STAGES = np.array([0, 1, 1, 2])  # in half steps


class AlongFlight(NamedTuple):
    """Surroundings of manoeuvres; last axis of lanes, one for each manoeuvre.

    steps : (intervals, steps, ..., lanes), as `Step`.  At the start (intervals, lanes) of each,
    sun : components of the unit vector, light : visible fraction, field : components [T] or None.
    """

    steps: Step
    sun: tuple[Floats, ...]
    light: Floats
    field: tuple[Floats, ...] | None


def along_flight(manoeuvre: Manoeuvre, intervals: int, steps: int, parts: int) -> AlongFlight:
    """Surroundings of one manoeuvre, without the axis of lanes.

    intervals : how many of its intervals, from the first on; those after its end go on.
    steps : Runge-Kutta steps an interval.  parts : of a step, with two Gauss points each.
    """
    satellite, count, begin = manoeuvre.satellite, intervals * steps, manoeuvre.start_time
    step = manoeuvre.step / steps
    halves: Floats = begin + 0.5 * step * np.arange(2.0 * count + 1.0)
    along = surroundings_at(satellite, halves)
    sun, seen = sunlight_at(satellite, halves)
    shape = (intervals, steps)
    stages = (2 * np.arange(count)[:, None] + _STAGES).reshape(*shape, 4)
    weights = light_weights(
        lambda times: sunlight_at(satellite, times)[1], seen, begin, step, parts
    )
    every = slice(0, -1, 2 * steps)
    field = along.field
    return AlongFlight(
        Step(
            jax.tree.map(lambda leaf: np.asarray(leaf)[stages], along),
            Vector(*np.moveaxis(sun[1::2].reshape(*shape, 3), -1, 0)),
            weights.reshape(*shape, -1),
        ),
        tuple(sun[every].T),
        seen[every],
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
