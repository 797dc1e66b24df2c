"""Directions that a satellite may point along, as functions of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import jax
import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.alignment import align
from jaxatt.attitude.vectors import cross, dot, matvec, norm
from jaxatt.environment import epoch, frames, ground, igrf, sun
from jaxatt.environment.along_orbit import inertial_field
from jaxatt.environment.motion import Motion
from jaxatt.environment.precession import earth_fixed
from jaxatt.runtime.arrays import Floats


class Direction(Protocol):
    """A direction from a satellite, as a pytree."""

    def at(self, time: Array) -> Array:
        """Vector (3,) of any length in inertial axes at a time () [s] after time zero."""
        ...


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class AmongStars:
    """A direction (3,) that rests in inertial axes."""

    vector: Array | Floats

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        return jnp.asarray(self.vector, float)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class InOrbitAxes:
    """A direction (3,) that rests in the orbit frame; (0, 0, 1) is to the Earth's centre."""

    vector: Array | Floats
    motion: Motion

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        here = self.motion.at(time)
        return matvec(frames.matrix_io(here.position, here.velocity), self.vector)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class AlongVelocity:
    """The velocity relative to inertial axes."""

    motion: Motion

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        return self.motion.at(time).velocity


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ToSun:
    """The sun as seen from the Earth's centre; from a low orbit it stands 0.003 deg aside.

    days : of time zero, since J2000.
    """

    days: Array | float

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        return sun.sun_direction(_days(self.days, time))


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class AlongField:
    """The Earth's magnetic field where the satellite is."""

    motion: Motion
    days: Array | float
    model: igrf.MagneticModel

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        here = self.motion.at(time).position
        return inertial_field(self.model, here, _days(self.days, time))


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ToSite:
    """A place on the ground, without the time that light takes.

    latitude, longitude : [rad], geodetic.  height : [m] above the WGS 84 ellipsoid.
    """

    motion: Motion
    days: Array | float
    latitude: Array | float
    longitude: Array | float
    height: Array | float

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        place = ground.place(self.latitude, self.longitude, self.height)
        turned = matvec(earth_fixed(_days(self.days, time)).T, place)
        return turned - self.motion.at(time).position

    def elevation(self, time: Array) -> Array:
        """Angle () [rad] of the satellite above the horizon of the place."""
        here = ground.earth_fixed(self.motion.at(time).position, _days(self.days, time))
        return ground.elevation(here, self.latitude, self.longitude, self.height)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ToSatellite:
    """Another satellite."""

    motion: Motion
    other: Motion

    def at(self, time: Array) -> Array:
        """See `Direction`."""
        return self.from_here(time)[1]

    def from_here(self, time: Array) -> tuple[Array, Array]:
        """Where this satellite is, and the other one from there, (3,) [m] each."""
        here = self.motion.at(time).position
        return here, self.other.at(time).position - here


def pose(
    body: ArrayLike,
    toward: Direction,
    second_body: ArrayLike,
    second: Direction,
    time: Array | float,
) -> tuple[Array, Array]:
    """Attitude q_ib (4,), and the rate omega_ib (3,) [rad/s] with which it follows its directions.

    body : (3,), the axis that is aligned with `toward`.  second_body : (3,), the axis that is
    constrained towards `second`.
    """

    def attitude(t: Array) -> Array:
        return align(body, toward.at(t), second_body, second.at(t))

    time = jnp.asarray(time)
    q, moving = jax.jvp(attitude, (time,), (jnp.ones_like(time),))
    return q, 2.0 * quaternion.multiply(quaternion.conjugate(q), moving)[1:]


def apart(one: Direction, other: Direction, time: Array) -> Array:
    """Angle () [rad] between two directions."""
    a, b = one.at(time), other.at(time)
    return jnp.arctan2(norm(cross(a, b)), dot(a, b))


def _days(days: Array | float, time: Array) -> Array:
    return days + time / epoch.SECONDS_PER_DAY
