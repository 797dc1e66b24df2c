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
from jaxatt.environment import epoch
from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.interpolant import Interpolant, interpolate
from jaxatt.environment.light import Light, to_sun
from jaxatt.environment.occultation import Disks
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

STEP = 30.0
"""[s] Between the nodes of the table: relative errors below 1e-9 in low orbits."""


class Moment(NamedTuple):
    """Environment at one time.

    position : [m], sun : unit vector to the sun, and field : [T] or None, in inertial axes.
    disks : of sun and Earth as they are seen.
    q_io : attitude of the orbit frame, a unit quaternion of continuous sign.
    orbit_rate : [rad/s], its rate in inertial axes.
    gradient : () [1/s^2], 3 mu / r^3.
    """

    position: Vector
    sun: Vector
    field: Vector | None
    disks: Disks
    q_io: Quaternion
    orbit_rate: Vector
    gradient: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class EnvironmentInTime:
    """Environment as a function of time [s] since the epoch of the orbit; make with `in_time`.

    lit : sun, disks of sun and Earth and, where there is one, field.
    moving : q_io, its rate in inertial axes, and position.
    mu : () [m^3/s^2].  magnetic : whether there is a field.
    """

    lit: Interpolant
    moving: Interpolant
    mu: Array | float
    magnetic: bool = field(metadata={"static": True})

    def at(self, time: Array) -> Moment:
        """Environment at a time () [s]."""
        lit, moving = self.lit.at(time), self.moving.at(time)
        x, y, z, own, earth, apart, *field = (lit[i] for i in range(lit.shape[0]))
        eta, i, j, k, *parts = (moving[i] for i in range(moving.shape[0]))
        rate, position = Vector(*parts[:3]), Vector(*parts[3:])
        return Moment(
            position=position,
            sun=Vector(x, y, z),
            field=Vector(*field) if self.magnetic else None,
            disks=Disks(own, earth, apart),
            q_io=Quaternion(eta, Vector(i, j, k)).normalized(),
            orbit_rate=rate,
            gradient=3.0 * self.mu / position.norm() ** 3,
        )


def in_time(
    orbit: OrbitTask, light: Light, first: float, last: float, step: float = STEP
) -> EnvironmentInTime:
    """Tabulate the environment between two times [s] since the epoch of the orbit."""

    def lit(times: Floats) -> Floats:
        return np.asarray(_evaluated(orbit, light, jnp.asarray(times))[0])

    def moving(times: Floats) -> Floats:
        return _continuous(np.asarray(_evaluated(orbit, light, jnp.asarray(times))[1]))

    return EnvironmentInTime(
        interpolate(lit, first, last, step),
        interpolate(moving, first, last, step),
        orbit.motion.mu,
        orbit.field is not None,
    )


def _evaluate(orbit: OrbitTask, light: Light, times: Array) -> tuple[Array, Array]:
    """Channels (n, c) of the two tables, in the order that `EnvironmentInTime.at` reads."""
    along, nodes = evaluate(orbit, ExternalTorques(), True, times, light)
    assert along.down is not None and along.gradient is not None and along.sun is not None
    position = -jnp.cbrt(3.0 * orbit.motion.mu / along.gradient)[:, None] * along.down.array
    days = orbit.days + times / epoch.SECONDS_PER_DAY
    seen = (light.shadow or Shadow()).disks(position, to_sun(light, position, days))
    lit = [along.sun.array, jnp.stack(seen, axis=1)]
    if nodes.field is not None:
        lit.append(nodes.field.array)
    moving = [nodes.attitude.array, nodes.attitude.rotate(nodes.rate).array, position]
    return jnp.concatenate(lit, axis=1), jnp.concatenate(moving, axis=1)


_evaluated = jax.jit(_evaluate, compiler_options=RUNS_ONCE)


def _continuous(values: Floats) -> Floats:
    """The same channels, q_io first, without jumps of its sign."""
    q = values[:, :4]
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    q = q * np.concatenate([[1.0], np.cumprod(same)])[:, None]
    return np.concatenate([q, values[:, 4:]], axis=1)
