"""Rates of attitude, rotation and energy of a satellite with magnetorquers alone, eq. (6.2).

The attitude is a turn e from a fixed attitude q0 near by, four modified Rodrigues parameters: three
coordinates that stand for a unit quaternion whatever their values, so that no solver can harvest
power from the norm of one.  The source's omega_ob is algebraic and no state: (6.2d) has S(r) r = 0
where r x v is meant, and counts the transport term twice.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Matrix, Quaternion, Scalar, Vector
from jaxatt.environment.eclipse import gradual_share
from jaxatt.environment.external import Along
from jaxatt.environment.occultation import Disks
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.spacecraft.panels import collecting_area


class Now(NamedTuple):
    """Environment of a point, vectors in the body axes that the attitude q0 has.

    field : [T].  light : share of the sun's.  sun : unit vector.  For the gravity gradient down and
    gradient [1/s^2].
    """

    field: Vector
    light: Scalar
    sun: Vector
    down: Vector | None
    gradient: Scalar | None

    def seen(self, turn: Quaternion) -> Now:
        """The same in the axes that the body has after a turn from q0."""
        return self._replace(
            field=turn.rotate_inverse(self.field),
            sun=turn.rotate_inverse(self.sun),
            down=None if self.down is None else turn.rotate_inverse(self.down),
        )


class Here(NamedTuple):
    """Environment of a point with derivatives along the logarithm of the final time.

    Field and light have two, the sun has one.
    """

    now: Now
    field_slope: Vector
    field_bend: Vector
    light_slope: Scalar
    light_bend: Scalar
    sun_slope: Vector

    def seen(self, turn: Quaternion) -> Here:
        """The same in the axes that the body has after a turn from q0."""
        return self._replace(
            now=self.now.seen(turn),
            field_slope=turn.rotate_inverse(self.field_slope),
            field_bend=turn.rotate_inverse(self.field_bend),
            sun_slope=turn.rotate_inverse(self.sun_slope),
        )


def now(time: Array, q0: Quaternion, p: MagneticParameters, form: MagneticForm) -> Now:
    """Environment at a time () [s] after the start, in the body axes that q0 has."""
    lit = p.environment.lit.at(p.begin + time)
    down, gradient = None, None
    if form.gravity_gradient:
        moment = p.environment.at(p.begin + time)
        down = q0.rotate_inverse(moment.position * (-1.0 / moment.position.norm()))
        gradient = moment.gradient
    return Now(
        field=q0.rotate_inverse(Vector(*lit[6:9])),
        light=_light(lit[3:6], p),
        sun=q0.rotate_inverse(Vector(*lit[0:3])),
        down=down,
        gradient=gradient,
    )


def here(time: Array, q0: Quaternion, p: MagneticParameters, form: MagneticForm) -> Here:
    """The same with derivatives."""
    disks, slope, bend = p.environment.lit.to_second_order(p.begin + time)
    first, second = time * slope, time * slope + time**2 * bend
    sun_slope, field_slope = Vector(*first[0:3]), Vector(*first[6:9])
    light_slope, light_bend = _light_slopes(disks[3:6], first[3:6], second[3:6], p)
    return Here(
        now=now(time, q0, p, form),
        field_slope=q0.rotate_inverse(field_slope),
        field_bend=q0.rotate_inverse(Vector(*second[6:9])),
        light_slope=light_slope,
        light_bend=light_bend,
        sun_slope=q0.rotate_inverse(sun_slope),
    )


def _light(disks: Array, p: MagneticParameters) -> Array:
    """Share of the sun's light; the disks are (3,)."""
    if p.shadow is None:
        return jnp.ones_like(disks[0])
    return gradual_share(p.shadow, Disks(disks[0], disks[1], disks[2]), p.shadow_width)


def _light_slopes(
    disks: Array, slope: Array, bend: Array, p: MagneticParameters
) -> tuple[Array, Array]:
    """Two derivatives of the light; those of the disks (3,) are given."""
    still = jnp.zeros_like(disks[0])
    if p.shadow is None:
        return still, still

    def rate(by: Array) -> Array:
        def later(by: Array) -> Array:
            return _light(disks + by * (slope + 0.5 * by * bend), p)

        return jax.jvp(later, (by,), (jnp.ones_like(by),))[1]

    return jax.jvp(rate, (still,), (jnp.ones_like(still),))


def other_torques(omega: Vector, seen: Now, p: MagneticParameters) -> Vector:
    """Torques [kg m^2 per unit of time squared] but those of the dipoles."""
    along = Along(
        down=seen.down,
        gradient=None if seen.gradient is None else jnp.asarray(seen.gradient),
        sun=seen.sun,
        light=jnp.asarray(seen.light),
        field=seen.field,
    )
    upright = Quaternion(1.0, 0.0 * omega)
    torque: Vector = p.other.total(upright, omega / p.unit, along, Matrix.of(p.inertia), None)
    return torque * p.unit**2


def rates(
    e: Vector, omega: Vector, v: Vector, at: Now, p: MagneticParameters
) -> tuple[Vector, Vector, Array]:
    """Derivatives of e and omega_ib by the time in units, and net power [W].

    omega : per unit of time.  v : dipole in units of its limit.
    """
    sigma = 0.25 * e
    norm = 1.0 + sigma.dot(sigma)
    q = Quaternion((2.0 - norm) * (1.0 / norm), (2.0 / norm) * sigma)
    turning = (2.0 - norm) * omega + 2.0 * sigma.cross(omega) + (2.0 * sigma.dot(omega)) * sigma
    seen = at.seen(q)
    inertia = Matrix.of(p.inertia)
    dipole = (v.times(Vector.of(p.dipole_unit)) + Vector.of(p.residual)) * p.unit**2
    torque = dipole.cross(seen.field) + other_torques(omega, seen, p)
    spinning = Matrix.of(p.inverse) @ (torque - omega.cross(inertia @ omega))
    area = collecting_area(p.panels, seen.sun, p.panel_smoothing)
    drawn = v.times(v).dot(Vector.of(p.dipole_power))
    return turning, spinning, p.irradiance * seen.light * area - drawn - p.load
