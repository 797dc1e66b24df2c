"""The environment along the orbit, tabulated at the Runge-Kutta stage times.

The control does not change the orbit, so this is done once a manoeuvre and shared by all starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.environment import frames
from jaxatt.environment.motion import Motion
from jaxatt.environment.sinusoidal import sinusoidal_torque
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.lengths import held_on, rounded_up
from jaxatt.runtime.settings import RUNS_ONCE

_STAGE_OFFSETS = (0, 1, 1, 2)  # in half steps
_SHARED = 4096
"""Numbers of times that share a program are multiples of this."""


class Environment(NamedTuple):
    """Orbit frame and disturbances at one instant, or at many with leading axes.

    orbit_rate : (..., 3) [rad/s], omega_io in orbit axes.
    orbit_attitude : (..., 4), q_io, of either sign.
    gradient : (...) [1/s^2], 3 mu / r^3; zero where the gravity gradient is switched off.
    disturbance : (..., 3) [N m], external torque in body axes that depends on time only.
    """

    orbit_rate: Array
    orbit_attitude: Array
    gradient: Array
    disturbance: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class EnvironmentTable:
    """Environment at the Runge-Kutta stages of N intervals of S substeps each.

    stages : Environment with leading axes (N, S, 4), the four stage times of every substep.
    nodes : Environment with leading axis (N + 1,).
    substep : () [s]; or (N,) in a programme for several lengths, zero in what fills it up.
    """

    stages: Environment
    nodes: Environment
    substep: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Surroundings:
    """Orbit and known disturbances of a manoeuvre.

    motion : along the orbit; None where attitudes refer to the inertial frame, which then stands
        for the orbit frame.
    gravity_gradient : () 0 or 1, whether the gravity gradient torque acts (4.11).
    sine_amplitude : () [N m] and sine_frequency : () [rad/s] of the sinusoidal torque (4.12).
    """

    motion: Motion | None
    gravity_gradient: Array
    sine_amplitude: Array
    sine_frequency: Array


def environment_at(surroundings: Surroundings, time: Array) -> Environment:
    """Environment at the given times, `time` of any shape [s] after time zero."""
    sine = sinusoidal_torque(time, surroundings.sine_amplitude, surroundings.sine_frequency)
    if surroundings.motion is None:
        still = jnp.zeros_like(sine)
        upright = jnp.concatenate([jnp.ones_like(sine[..., :1]), still], axis=-1)
        return Environment(still, upright, still[..., 0], sine)
    here = surroundings.motion.at(time)
    radius = jnp.linalg.norm(here.position, axis=-1)
    return Environment(
        frames.omega_io(*here),
        frames.quaternion_io(here.position, here.velocity),
        surroundings.gravity_gradient * 3.0 * surroundings.motion.mu / radius**3,
        sine,
    )


_on_grid = Routine(environment_at, options=RUNS_ONCE)


def _values(surroundings: Surroundings, time: np.ndarray) -> Any:
    """Environment at times (T,) [s] on the host, by a program that other numbers of times share."""
    more = rounded_up(len(time), _SHARED) - len(time)
    found = _on_grid(surroundings, held_on(time, more))
    return jax.tree.map(lambda leaf: np.asarray(leaf)[: len(time)], found)


def _without_jumps(q: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) along a motion, with signs chosen so that they are continuous."""
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(same)])[:, None]


def tabulate(
    surroundings: Surroundings, start: float, step: float, intervals: int, substeps: int
) -> EnvironmentTable:
    """Tabulate the environment of a roll-out, with the sign of q_io continuous along it.

    start : [s] time of the first node.  step : [s] length of one of the `intervals`.
    """
    half = step / (2 * substeps)
    substep: Any = np.asarray(2 * half)
    grid = start + half * np.arange(2 * substeps * intervals + 1)
    values = _values(surroundings, grid)
    values = values._replace(orbit_attitude=_without_jumps(values.orbit_attitude))
    first = 2 * np.arange(intervals * substeps).reshape(intervals, substeps)
    stages = first[..., None] + np.asarray(_STAGE_OFFSETS)
    nodes = 2 * substeps * np.arange(intervals + 1)
    return EnvironmentTable(
        jax.tree.map(lambda leaf: leaf[stages], values),
        jax.tree.map(lambda leaf: leaf[nodes], values),
        substep,
    )


def refined(table: EnvironmentTable) -> EnvironmentTable:
    """The same table with every substep as an interval of its own."""

    def each(leaf: Array) -> np.ndarray:
        stages = np.asarray(leaf)
        return stages.reshape(-1, 1, *stages.shape[2:])

    def ends(leaf: Array) -> np.ndarray:
        stages = each(leaf)[:, 0]
        return np.concatenate([stages[:, 0], stages[-1:, 3]])

    nodes = jax.tree.map(ends, table.stages)
    return EnvironmentTable(jax.tree.map(each, table.stages), nodes, table.substep)


def coarsen(table: EnvironmentTable, intervals: int, substeps: int) -> EnvironmentTable:
    """The first `intervals` of a table with fewer `substeps`, which must divide its own."""
    ratio = table.stages.gradient.shape[1] // substeps

    def pick(leaf: Array) -> np.ndarray:
        fine = np.asarray(leaf)[:intervals].reshape(intervals, substeps, ratio, *leaf.shape[2:])
        middle = fine[:, :, ratio // 2, 0] if ratio % 2 == 0 else fine[:, :, ratio // 2, 1]
        return np.stack([fine[:, :, 0, 0], middle, middle, fine[:, :, -1, 3]], axis=2)

    nodes = jax.tree.map(lambda leaf: leaf[: intervals + 1], table.nodes)
    return EnvironmentTable(jax.tree.map(pick, table.stages), nodes, table.substep * ratio)
