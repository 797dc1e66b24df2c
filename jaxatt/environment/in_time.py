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
    """

    position: Vector
    sun: Vector
    field: Vector | None
    clearance: Array
    q_io: Quaternion
    orbit_rate: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class EnvironmentInTime:
    """Environment as a function of time [s] since the epoch of the orbit; make with `in_time`.

    magnetic : whether there is a field.
    """

    table: Interpolant
    magnetic: bool = field(metadata={"static": True})

    def at(self, time: Array) -> Moment:
        """Environment at a time () [s]."""
        return self.named(self.table.at(time))

    def named(self, values: Array) -> Moment:
        """Channels (channels,) of the table by name."""
        v = tuple(values[i] for i in range(values.shape[0]))
        return Moment(
            position=Vector(*v[9:12]),
            sun=Vector(*v[0:3]),
            field=Vector(*v[12:15]) if self.magnetic else None,
            clearance=v[3],
            q_io=Quaternion(v[4], Vector(*v[5:8])).normalized(),
            orbit_rate=v[8],
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

    def values(times: Floats) -> Floats:
        return _continuous(np.asarray(_channels(orbit, light.sun, jnp.asarray(times))))

    return EnvironmentInTime(interpolate(values, first, last, step), orbit.field is not None)


def _channels(orbit: OrbitTask, fixed_sun: Array | Floats | None, times: Array) -> Array:
    """Channels (n, c) of the table, in the order that `EnvironmentInTime.named` reads."""
    return _evaluated(orbit, None if fixed_sun is None else jnp.asarray(fixed_sun), times)


def _evaluate(orbit: OrbitTask, fixed_sun: Array | None, times: Array) -> Array:
    along, nodes = evaluate(orbit, ExternalTorques(), True, times)
    assert along.down is not None and along.gradient is not None
    down = along.down.array
    radius = jnp.cbrt(3.0 * orbit.mu / along.gradient)[:, None]
    position = -radius * down
    if fixed_sun is None:
        to_sun = sun.sun_direction(orbit.days + times / epoch.SECONDS_PER_DAY)
    else:
        to_sun = jnp.broadcast_to(fixed_sun / jnp.linalg.norm(fixed_sun), position.shape)
    across = jnp.sqrt(1.0 - (sun.EARTH_RADIUS / radius[:, 0]) ** 2)
    clearance = across - jnp.sum(down * to_sun, axis=1)
    parts = [to_sun, clearance[:, None], nodes.attitude.array, nodes.rate.array[:, 1:2], position]
    if nodes.field is not None:
        parts.append(nodes.field.array)
    return jnp.concatenate(parts, axis=1)


_evaluated = jax.jit(_evaluate, compiler_options=RUNS_ONCE)


def _continuous(values: Floats) -> Floats:
    """The same channels with signs of q_io that do not jump."""
    q = values[:, 4:8]
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    return np.concatenate(
        [values[:, :4], q * np.concatenate([[1.0], np.cumprod(same)])[:, None], values[:, 8:]],
        axis=1,
    )
