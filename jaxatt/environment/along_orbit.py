"""Environment along the orbit, tabulated once for all runs of a flight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude.components import Quaternion, Scalar, Vector
from jaxatt.attitude.vectors import matvec
from jaxatt.environment import epoch, frames, igrf, sun
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.environment.light import Light, sunlight
from jaxatt.environment.motion import Motion
from jaxatt.environment.precession import earth_fixed
from jaxatt.environment.sinusoidal import sinusoidal_torque

_STAGES = np.array([0, 1, 1, 2])  # in half steps
_BLOCK = 8192  # instants of one evaluation


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class OrbitTask:
    """Orbit, epoch and disturbances from which the environment is tabulated.

    motion : along the orbit, in inertial axes (J2000).
    days : epoch of time zero, days since J2000.
    field : coefficients at the epoch, None where no magnetism acts.
    sun : (3,), fixed unit vector to an always shining sun, as Kristiansen (2023) has it; None for
    the true one with eclipses.  sine : () [N m] and frequency : () [rad/s] of the known sine.
    """

    motion: Motion
    days: Array | float
    field: igrf.MagneticModel | None = None
    sun: Array | None = None
    sine: Array | float = 0.0
    frequency: Array | float = 1.0


class Nodes(NamedTuple):
    """Attitude and rate of the reference frame, and the magnetic field, at the sampling instants.

    attitude : q_io.  rate : omega_io [rad/s] in orbit axes.  field : [T] in inertial axes, or None.
    """

    attitude: Quaternion
    rate: Vector
    field: Vector | None


def inertial_nodes(count: int) -> Nodes:
    """Nodes (count,) of a flight without an orbit, whose reference frame is inertial."""
    zero, one = jnp.zeros(count), jnp.ones(count)
    return Nodes(Quaternion(one, Vector(zero, zero, zero)), Vector(zero, zero, zero), None)


def evaluate(
    task: OrbitTask,
    torques: ExternalTorques,
    tidal: bool,
    times: Array,
    light: Light | None = None,
    width: Scalar = 0.0,
) -> tuple[Along, Nodes]:
    """Evaluate environment and reference frame at the given times (n,) [s] after the epoch.

    light : gives sun and light, for panels and for solar pressure.  width : [rad], of the edges of
    its shadow, as in `lit_share`; 0 is exact.
    """
    here = task.motion.at(times)
    r_i, v_i = here.position, here.velocity
    radius = jnp.linalg.norm(r_i, axis=-1)
    days = task.days + times / epoch.SECONDS_PER_DAY
    field = None if task.field is None else Vector.of(inertial_field(task.field, r_i, days))
    to_sun, share = None, None
    if light is not None:
        direction, share = sunlight(light, r_i, days, width)
        to_sun = Vector.of(direction)
    elif torques.solar_pressure is not None and task.sun is not None:
        to_sun = Vector.of(jnp.broadcast_to(task.sun, r_i.shape))
        share = jnp.ones_like(times)
    elif torques.solar_pressure is not None:
        direction = sun.sun_direction(days)
        to_sun, share = Vector.of(direction), sun.visible_fraction(r_i, direction)
    drag = torques.drag
    along = Along(
        down=Vector.of(-r_i / radius[:, None]) if tidal else None,
        gradient=3.0 * task.motion.mu / radius**3 if tidal else None,
        air_speed=None if drag is None else drag.air_speed(Vector.of(r_i), Vector.of(v_i)),
        sun=to_sun,
        light=share,
        field=field,
        disturbance=Vector.of(sinusoidal_torque(times, task.sine, task.frequency)),
    )
    nodes = Nodes(
        Quaternion.of(frames.quaternion_io(r_i, v_i)),
        Vector.of(frames.omega_io(*here)),
        field,
    )
    return along, nodes


def inertial_field(model: igrf.MagneticModel, r_i: Array, days: Array) -> Array:
    """Magnetic field (..., 3) [T] at inertial positions (..., 3) [m]; days (...) since J2000."""
    turn = earth_fixed(days)
    return matvec(jnp.swapaxes(turn, -1, -2), igrf.field(model, matvec(turn, r_i)))


_evaluated = jax.jit(evaluate, static_argnames="tidal")


def tabulate(
    task: OrbitTask,
    torques: ExternalTorques,
    tidal: bool,
    step: float,
    steps: int,
    start: float = 0.0,
    light: Light | None = None,
    width: float = 0.0,
) -> tuple[Along, Nodes]:
    """Tabulate Along (steps, 4) at the Runge-Kutta stages, and Nodes (steps + 1,).

    step : [s].  start : [s] after the epoch.  light, width : as in `evaluate`.
    """
    times = start + 0.5 * step * np.arange(2 * steps + 1)
    padded = np.pad(times, (0, -len(times) % min(_BLOCK, len(times))), mode="edge")
    blocks = [
        jax.tree.map(np.asarray, _evaluated(task, torques, tidal, block, light, width))
        for block in padded.reshape(-1, min(_BLOCK, len(times)))
    ]
    along, nodes = jax.tree.map(lambda *rows: np.concatenate(rows)[: len(times)], *blocks)
    stages = 2 * np.arange(steps)[:, None] + _STAGES
    return (
        jax.tree.map(lambda leaf: leaf[stages], along),
        jax.tree.map(lambda leaf: leaf[::2], nodes),
    )
