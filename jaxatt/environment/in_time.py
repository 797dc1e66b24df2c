"""The environment along an orbit as a traceable function of time.

Where the final time is free the nodes move, and with them field, sun and eclipse.  So they are
tabulated once, densely, and interpolated; a time may then be batched and differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.environment import epoch, sun
from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.interpolant import Interpolant, interpolate
from jaxatt.environment.light import Light
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

STEP = 30.0
"""[s] Between the nodes of the table: relative errors below 1e-9 in low orbits."""


class Moment(NamedTuple):
    """Environment at one time.

    position : [m], sun : unit vector to the sun, and field : [T] or None, in inertial axes.
    clearance : (), margin to the Earth's shadow: the cosine of the horizon's distance from the
    nadir less that of the sun's.  It is positive where the centre of the sun is above the horizon,
    and smooth all along the orbit.
    q_io : attitude of the orbit frame, a unit quaternion of continuous sign.
    orbit_rate : () [rad/s], its rate about its own y axis, negative.
    gradient : () [1/s^2], 3 mu / r^3.
    """

    position: Vector
    sun: Vector
    field: Vector | None
    clearance: Array
    q_io: Quaternion
    orbit_rate: Array
    gradient: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class EnvironmentInTime:
    """Environment as a function of time [s] since the epoch of the orbit; make with `in_time`.

    lit : sun, clearance and, where there is one, field.  moving : q_io, its rate and position.
    mu : () [m^3/s^2].  magnetic : whether there is a field.
    """

    lit: Interpolant
    moving: Interpolant
    mu: Array | float
    magnetic: bool = field(metadata={"static": True})

    def at(self, time: Array) -> Moment:
        """Environment at a time () [s]."""
        lit, moving = self.lit.at(time), self.moving.at(time)
        x, y, z, clearance, *field = (lit[i] for i in range(lit.shape[0]))
        eta, i, j, k, rate, *place = (moving[i] for i in range(moving.shape[0]))
        position = Vector(*place)
        return Moment(
            position=position,
            sun=Vector(x, y, z),
            field=Vector(*field) if self.magnetic else None,
            clearance=clearance,
            q_io=Quaternion(eta, Vector(i, j, k)).normalized(),
            orbit_rate=rate,
            gradient=3.0 * self.mu / position.norm() ** 3,
        )


def smooth_light(clearance: Array, width: Array | float) -> Array:
    """Share of sunlight () between 0 and 1, smooth across the edge of the shadow.

    clearance : see `Moment`.  width : of the rise, in the same units; a low orbit crosses about a
    thousandth of them a second.
    """
    return 0.5 * (1.0 + jnp.tanh(clearance / width))


def in_time(
    orbit: OrbitTask, light: Light, first: float, last: float, step: float = STEP
) -> EnvironmentInTime:
    """Tabulate the environment between two times [s] since the epoch of the orbit."""

    fixed = None if light.sun is None else jnp.asarray(light.sun)

    def lit(times: Floats) -> Floats:
        return np.asarray(_evaluated(orbit, fixed, jnp.asarray(times))[0])

    def moving(times: Floats) -> Floats:
        return _continuous(np.asarray(_evaluated(orbit, fixed, jnp.asarray(times))[1]))

    return EnvironmentInTime(
        interpolate(lit, first, last, step),
        interpolate(moving, first, last, step),
        orbit.mu,
        orbit.field is not None,
    )


def _evaluate(orbit: OrbitTask, fixed_sun: Array | None, times: Array) -> tuple[Array, Array]:
    """Channels (n, c) of the two tables, in the order that `EnvironmentInTime.at` reads."""
    along, nodes = evaluate(orbit, ExternalTorques(), True, times)
    assert along.down is not None and along.gradient is not None
    down = along.down.array
    radius = jnp.cbrt(3.0 * orbit.mu / along.gradient)[:, None]
    if fixed_sun is None:
        to_sun = sun.sun_direction(orbit.days + times / epoch.SECONDS_PER_DAY)
    else:
        to_sun = jnp.broadcast_to(fixed_sun / jnp.linalg.norm(fixed_sun), down.shape)
    horizon = jnp.sqrt(1.0 - (sun.EARTH_RADIUS / radius) ** 2)
    clearance = horizon - jnp.sum(down * to_sun, axis=1, keepdims=True)
    lit = [to_sun, clearance] + ([] if nodes.field is None else [nodes.field.array])
    moving = [nodes.attitude.array, nodes.rate.array[:, 1:2], -radius * down]
    return jnp.concatenate(lit, axis=1), jnp.concatenate(moving, axis=1)


_evaluated = jax.jit(_evaluate, compiler_options=RUNS_ONCE)


def _continuous(values: Floats) -> Floats:
    """The same channels, q_io first, without jumps of its sign."""
    q = values[:, :4]
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    q = q * np.concatenate([[1.0], np.cumprod(same)])[:, None]
    return np.concatenate([q, values[:, 4:]], axis=1)
