"""External influences and sunlight of a satellite at given times, on the host."""

from __future__ import annotations

import dataclasses
import math

import jax
import numpy as np

from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.environment.light import Light
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_BLOCK = 1024  # instants of one evaluation
_SPACING = 4.0
"""[s], of the table in which slow influences are interpolated.  The finest pattern of the field
takes 400 s to pass: a cubic through four points is right to 1e-9 of it."""

_evaluated = jax.jit(evaluate, static_argnames="tidal", compiler_options=RUNS_ONCE)


def sunlight_at(satellite: Satellite, times: Floats) -> tuple[Floats, Floats]:
    """Unit vector (n, 3) to the sun in inertial axes, and the exact share (n,) of its light.

    times : (n,) [s] since the epoch of the orbit.
    Raises `ValueError` where neither an orbit nor a fixed direction says where the sun is.
    """
    light, count = satellite.light, len(times)
    if satellite.orbit is None:
        if light.sun is None:
            raise ValueError(
                "light: a satellite without an orbit has no date, so its sun must be fixed; give "
                "the direction of the sun in inertial axes, or an orbit"
            )
        fixed = np.asarray(light.sun, float)
        return np.broadcast_to(fixed / np.linalg.norm(fixed), (count, 3)), np.ones(count)
    orbit = dataclasses.replace(satellite.orbit, field=None)
    along = _blockwise(orbit, ExternalTorques(), False, times, light)
    assert along.sun is not None and along.light is not None
    return np.asarray(along.sun.array), np.asarray(along.light)


def surroundings_at(satellite: Satellite, times: Floats) -> Along:
    """What the external torques need, at times (n,) [s] in rising order; without a torque, nothing.

    What varies with the orbit is interpolated by cubics; what may be faster is evaluated.
    """
    orbit, torques = satellite.orbit, satellite.torques
    if orbit is None:
        return Along()
    pressed = torques.solar_pressure is not None or float(orbit.sine) != 0.0
    if pressed:
        light = satellite.light if torques.solar_pressure is not None else None
        return _blockwise(orbit, torques, satellite.gravity_gradient, times, light)
    first, last = float(times[0]), float(times[-1])
    cells = max(1, math.ceil((last - first) / _SPACING))
    spacing = (last - first) / cells if last > first else _SPACING
    grid: Floats = first + spacing * np.arange(-1.0, cells + 2.0)
    table = _blockwise(orbit, torques, satellite.gravity_gradient, grid, None)
    table = table._replace(disturbance=None)
    cell = np.clip(((times - first) / spacing).astype(int), 0, cells - 1)
    weights = _cubic((times - first) / spacing - cell)

    def between(leaf: Floats) -> Floats:
        total: Floats = sum(weights[k] * leaf[cell + k] for k in range(4))
        return total

    interpolated: Along = jax.tree.map(between, table)
    return interpolated


def _cubic(x: Floats) -> list[Floats]:
    """Weights of Lagrange's cubic for the points -1, 0, 1 and 2."""
    return [
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    ]


def _blockwise(
    orbit: OrbitTask, torques: ExternalTorques, tidal: bool, times: Floats, light: Light | None
) -> Along:
    """Along (n,), evaluated in blocks of one compiled size."""
    count = len(times)
    padded = np.pad(times, (0, -count % _BLOCK), mode="edge")
    rows = [
        jax.tree.map(np.asarray, _evaluated(orbit, torques, tidal, block, light)[0])
        for block in padded.reshape(-1, _BLOCK)
    ]
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *rows)
