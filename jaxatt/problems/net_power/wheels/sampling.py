"""Environment along the intervals of a manoeuvre, sampled once for all starts."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import numpy as np
from jax import Array

from jaxatt.environment import epoch
from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.environment.light import Light, sunlight
from jaxatt.runtime.arrays import Floats

_BLOCK = 1024  # instants of one compiled evaluation
_SAMPLES = 8  # of the light, an interval
_DENSE = 64  # of them where the light is to move smoothly with the edges of the shadow


@partial(jax.jit, static_argnames="tidal")
def _along(task: OrbitTask, torques: ExternalTorques, tidal: bool, times: Array) -> Along:
    return evaluate(task, torques, tidal, times)[0]


@jax.jit
def _sunlight(
    task: OrbitTask, light: Light, times: Array, width: float = 0.0
) -> tuple[Array, Array]:
    r_i = task.motion.at(times).position
    return sunlight(light, r_i, task.days + times / epoch.SECONDS_PER_DAY, width)


def _in_blocks(run: Any, times: Any) -> Any:
    padded = np.pad(times, (0, -len(times) % _BLOCK), mode="edge").reshape(-1, _BLOCK)
    found = [jax.tree.map(np.asarray, run(block)) for block in padded]
    return jax.tree.map(lambda *rows: np.concatenate(rows)[: len(times)], *found)


def environment(task: OrbitTask, torques: ExternalTorques, tidal: bool, middles: Floats) -> Along:
    """Environment at the given instants (N, m) [s] after the epoch, leading axes (N, m)."""
    found = _in_blocks(lambda times: _along(task, torques, tidal, times), middles.ravel())
    shape = middles.shape
    return jax.tree.map(lambda leaf: leaf.reshape(*shape, *leaf.shape[1:]), found)


def sun_along(
    task: OrbitTask | None,
    light: Light,
    start: float,
    step: float,
    intervals: int,
    edges: float = 0.0,
) -> tuple[Floats, Floats]:
    """Direction of the sun (N + 1, 3) at the nodes, and light (N + 1,) [J/m^2] of each.

    The light is integrated over the hat function of every node, so that a shadow that begins
    within an interval counts from there.
    edges : [rad], width of the shadow's edges; 0 is exact.
    """
    count = _DENSE if edges else _SAMPLES
    nodes = start + step * np.arange(intervals + 1)
    irradiance = float(light.irradiance)
    if task is None:
        if light.sun is None:
            raise ValueError(
                "light.sun is missing and there is no orbit; give the vector to the sun, or an "
                "orbit and an epoch"
            )
        given = np.asarray(light.sun, float)
        direction = np.broadcast_to(given / np.linalg.norm(given), (intervals + 1, 3))
        share = np.ones((intervals, count))
    else:
        within = (np.arange(count) + 0.5) / count
        samples = start + step * (np.arange(intervals)[:, None] + within)
        direction = _in_blocks(lambda times: _sunlight(task, light, times)[0], nodes)
        lit = _in_blocks(lambda times: _sunlight(task, light, times, edges)[1], samples.ravel())
        share = np.asarray(lit).reshape(intervals, count)
    rising = (np.arange(count) + 0.5) / count
    each = irradiance * step / count
    shone = np.zeros(intervals + 1)
    shone[:-1] += each * (share * (1.0 - rising)).sum(axis=1)
    shone[1:] += each * (share * rising).sum(axis=1)
    return np.array(direction), shone
