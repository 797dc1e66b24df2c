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


class Here(NamedTuple):
    """Environment of a point, vectors in the body axes that the attitude q0 has.

    With derivatives along the logarithm of the final time: field [T] and light with two, the sun
    (a unit vector) with one.  For the gravity gradient down and gradient [1/s^2].
    """

    field: Vector
    field_slope: Vector
    field_bend: Vector
    light: Scalar
    light_slope: Scalar
    light_bend: Scalar
    sun: Vector
    sun_slope: Vector
    down: Vector | None
    gradient: Scalar | None

    def seen(self, turn: Quaternion) -> Here:
        """The same in the axes that the body has after a turn from q0."""
        return self._replace(
            field=turn.rotate_inverse(self.field),
            field_slope=turn.rotate_inverse(self.field_slope),
            field_bend=turn.rotate_inverse(self.field_bend),
            sun=turn.rotate_inverse(self.sun),
            sun_slope=turn.rotate_inverse(self.sun_slope),
            down=None if self.down is None else turn.rotate_inverse(self.down),
        )


def here(time: Array, q0: Quaternion, p: MagneticParameters, form: MagneticForm) -> Here:
    """Environment at a time () [s] after the start, in the body axes that q0 has."""
    lit, slope, bend = p.environment.lit.to_second_order(p.begin + time)
    first, second = time * slope, time * slope + time**2 * bend
    down, gradient = None, None
    if form.gravity_gradient:
        moment = p.environment.at(p.begin + time)
        down = q0.rotate_inverse(moment.position * (-1.0 / moment.position.norm()))
        gradient = moment.gradient
    orders = (lit, first, second)
    sun, sun_slope, _ = (q0.rotate_inverse(Vector(*order[0:3])) for order in orders)
    field, field_slope, field_bend = (q0.rotate_inverse(Vector(*order[6:9])) for order in orders)
    light, light_slope, light_bend = _light(lit[3:6], first[3:6], second[3:6], p)
    return Here(
        field=field,
        field_slope=field_slope,
        field_bend=field_bend,
        light=light,
        light_slope=light_slope,
        light_bend=light_bend,
        sun=sun,
        sun_slope=sun_slope,
        down=down,
        gradient=gradient,
    )


def _light(
    disks: Array, slope: Array, bend: Array, p: MagneticParameters
) -> tuple[Array, Array, Array]:
    """Share of the sun's light with two derivatives; those of the disks (3,) are given."""
    now = jnp.zeros_like(disks[0])
    if p.shadow is None:
        return now + 1.0, now, now
    shadow = p.shadow

    def later(by: Array) -> Array:
        moved = disks + by * (slope + 0.5 * by * bend)
        return gradual_share(shadow, Disks(moved[0], moved[1], moved[2]), p.shadow_width)

    def sloped(by: Array) -> tuple[Array, Array]:
        return jax.jvp(later, (by,), (jnp.ones_like(by),))

    (value, rate), (_, change) = jax.jvp(sloped, (now,), (jnp.ones_like(now),))
    return value, rate, change


def other_torques(omega: Vector, seen: Here, p: MagneticParameters) -> Vector:
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
    e: Vector, omega: Vector, v: Vector, at: Here, p: MagneticParameters
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
