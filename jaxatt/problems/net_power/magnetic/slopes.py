"""Derivatives of the rates at one point, in closed form, by turn, rate, dipole and final time."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Matrix, Scalar, Vector
from jaxatt.problems.net_power.magnetic.blocks import (
    Turn,
    crossed,
    identity,
    outer,
    pulled_slope,
    rate_slope,
    scaled,
    skew,
    small_slope,
    times,
    total,
    transposed,
    turn,
)
from jaxatt.problems.net_power.magnetic.motion import Here, other_torques
from jaxatt.problems.net_power.magnetic.parameters import MagneticParameters
from jaxatt.spacecraft.panels import collecting_area


class Slopes(NamedTuple):
    """Rates and their derivatives, all per unit of time; the last one is by the log of the time.

    turning, spinning : rates of turn and rate.  power : [W].
    turning_by_turn, turning_by_rate; spinning_by_turn, spinning_by_rate, spinning_by_dipole :
    matrices; spinning_by_time : what the field's change makes.
    power_by_turn, power_by_dipole, power_by_time.
    turn, seen, dipole, area, area_slope : what the second derivatives use again.
    """

    turning: Vector
    spinning: Vector
    power: Scalar
    turning_by_turn: Matrix
    turning_by_rate: Matrix
    spinning_by_turn: Matrix
    spinning_by_rate: Matrix
    spinning_by_dipole: Matrix
    spinning_by_time: Vector
    power_by_turn: Vector
    power_by_dipole: Vector
    power_by_time: Scalar
    turn: Turn
    seen: Here
    dipole: Vector
    area: Scalar
    area_slope: Vector


def slopes(e: Vector, omega: Vector, v: Vector, at: Here, p: MagneticParameters) -> Slopes:
    """Rates of `motion.rates` with their first derivatives."""
    here = turn(e)
    seen = at.seen(here.attitude)
    inertia, inverse = Matrix.of(p.inertia), Matrix.of(p.inverse)
    limit, share = Vector.of(p.dipole_unit) * p.unit**2, Vector.of(p.dipole_power)
    dipole = v.times(limit) + Vector.of(p.residual) * p.unit**2
    other, by_small, by_rate, by_time = _others(omega, seen, p)
    momentum = inertia @ omega
    torque = dipole.cross(seen.now.field) + other - omega.cross(momentum)
    pull = total(crossed(dipole, skew(seen.now.field)), by_small)
    spin = total(skew(momentum), scaled(crossed(omega, inertia), -1.0), by_rate)
    area, area_slope = jax.value_and_grad(_area)(seen.now.sun, p)
    shone = p.irradiance * seen.now.light
    by_dipole = skew(-seen.now.field)
    columns = tuple(row.times(limit) for row in by_dipole.rows)
    return Slopes(
        turning=here.rate @ omega,
        spinning=inverse @ torque,
        power=shone * area - v.times(v).dot(share) - p.load,
        turning_by_turn=rate_slope(here, omega),
        turning_by_rate=here.rate,
        spinning_by_turn=times(inverse, times(pull, here.small)),
        spinning_by_rate=times(inverse, spin),
        spinning_by_dipole=times(inverse, Matrix((columns[0], columns[1], columns[2]))),
        spinning_by_time=inverse @ (dipole.cross(seen.field_slope) + by_time),
        power_by_turn=transposed(here.small) @ (shone * area_slope.cross(seen.now.sun)),
        power_by_dipole=-2.0 * v.times(share),
        power_by_time=p.irradiance * seen.light_slope * area
        + shone * area_slope.dot(seen.sun_slope),
        turn=here,
        seen=seen,
        dipole=dipole,
        area=area,
        area_slope=area_slope,
    )


def _area(sun_b: Vector, p: MagneticParameters) -> Array:
    return jnp.asarray(collecting_area(p.panels, sun_b, p.panel_smoothing))


def _others(
    omega: Vector, seen: Here, p: MagneticParameters
) -> tuple[Vector, Matrix, Matrix, Vector]:
    """Small torques, with derivatives by a small turn, by the rate and by the time."""
    zero = 0.0 * omega.x

    def torque(turned: Vector, omega: Vector, later: Scalar) -> Vector:
        after = seen.now._replace(
            field=seen.now.field + seen.now.field.cross(turned) + later * seen.field_slope,
            sun=seen.now.sun + seen.now.sun.cross(turned),
            down=None if seen.now.down is None else seen.now.down + seen.now.down.cross(turned),
        )
        return other_torques(omega, after, p)

    still = Vector(zero, zero, zero)
    if seen.now.down is None and not p.others_act:
        nothing = Matrix((still, still, still))
        return still, nothing, nothing, still
    value = torque(still, omega, zero)
    columns = []
    for k in range(7):
        unit = [zero + float(i == k) for i in range(7)]
        tangents = Vector(*unit[:3]), Vector(*unit[3:6]), unit[6]
        columns.append(jax.jvp(torque, (still, omega, zero), tangents)[1])
    by_small = transposed(Matrix((columns[0], columns[1], columns[2])))
    by_rate = transposed(Matrix((columns[3], columns[4], columns[5])))
    return value, by_small, by_rate, columns[6]


class Bends(NamedTuple):
    """Second derivatives of weighted rates, in units of the final time; symmetric in pairs.

    The first-named coordinate counts the rows.
    """

    turn_turn: Matrix
    rate_turn: Matrix
    rate_rate: Matrix
    dipole_turn: Matrix
    dipole_dipole: Vector
    turn_time: Vector
    rate_time: Vector
    dipole_time: Vector
    time_time: Scalar


def bends(
    found: Slopes,
    omega: Vector,
    weights: tuple[Vector, Vector, Scalar],
    by_energy: bool,
    p: MagneticParameters,
) -> tuple[tuple[Vector, Vector], Bends]:
    """Gradient by turn and rate, and `Bends`, of weighted rates times the final time.

    weights : of turning, spinning, both times the final time, and of the power, times the final
    time where the cost is the energy.  Second derivatives of the small torques are left out.
    """
    a, b, c = weights
    inertia, inverse = Matrix.of(p.inertia), Matrix.of(p.inverse)
    limit, share = Vector.of(p.dipole_unit) * p.unit**2, Vector.of(p.dipole_power)
    here, seen = found.turn, found.seen
    field, sun = seen.now.field, seen.now.sun
    force = transposed(inverse) @ b
    felt = force.cross(found.dipole)
    shone = c * p.irradiance * seen.now.light
    slope = found.area_slope
    curved = _area_bend(sun, p)
    lever = crossed(sun, times(curved, skew(sun)))
    small = total(
        crossed(felt, skew(field)),
        scaled(crossed(slope, skew(sun)), shone),
        scaled(lever, -shone),
    )
    pulled = felt.cross(field) + shone * slope.cross(sun)
    back = transposed(here.small)
    turn_turn = total(
        _kinematic_bend(a, omega),
        times(back, times(small, here.small)),
        small_slope(here, pulled),
    )
    by_turn = transposed(found.turning_by_turn) @ a + transposed(found.spinning_by_turn) @ b
    by_rate = transposed(found.turning_by_rate) @ a + transposed(found.spinning_by_rate) @ b
    lit = p.irradiance * seen.light_slope
    energy = 1.0 if by_energy else 0.0
    turn_time = by_turn + back @ (felt.cross(seen.field_slope) + (c * lit) * slope.cross(sun))
    turn_time = turn_time + energy * c * found.power_by_turn
    swung = scaled(times(crossed(force, skew(field)), here.small), -1.0)
    pull = (field + seen.field_slope).cross(force).times(limit)
    time_time = (
        a.dot(found.turning)
        + b.dot(found.spinning + 2.0 * found.spinning_by_time)
        + felt.dot(seen.field_bend)
        + c * p.irradiance * seen.light_bend * found.area
        + energy * c * (found.power + 2.0 * found.power_by_time)
    )
    return (by_turn + c * found.power_by_turn, by_rate), Bends(
        turn_turn=turn_turn,
        rate_turn=pulled_slope(here, a),
        rate_rate=total(crossed(force, inertia), scaled(times(inertia, skew(force)), -1.0)),
        dipole_turn=Matrix(
            (swung.rows[0] * limit.x, swung.rows[1] * limit.y, swung.rows[2] * limit.z)
        ),
        dipole_dipole=-2.0 * c * share,
        turn_time=turn_time,
        rate_time=by_rate,
        dipole_time=pull + energy * c * found.power_by_dipole,
        time_time=time_time,
    )


def _kinematic_bend(a: Vector, omega: Vector) -> Matrix:
    """Second derivative of a' K omega by the turn, the same at every turn."""
    both = total(outer(a, omega), outer(omega, a), identity(-a.dot(omega)))
    return scaled(both, 0.125)


def _area_bend(sun: Vector, p: MagneticParameters) -> Matrix:
    """Second derivatives of the collecting area by the sun's direction."""
    zero = 0.0 * sun.x
    rows = []
    for k in range(3):
        unit = Vector(*(zero + float(i == k) for i in range(3)))
        rows.append(jax.jvp(jax.grad(lambda s: _area(s, p)), (sun,), (unit,))[1])
    return Matrix((rows[0], rows[1], rows[2]))


def lost_power_bend(e: Vector, at: Here, p: MagneticParameters) -> Matrix:
    """Curvature by the turn of the power that the panels lose to the best they can have.

    By the law of squared cosines, and for faces that are equal on either side, the power is s'Q s
    of the sun's direction s, and what is lost s'(q - Q) s, q the largest eigenvalue: a sum of
    squares.  Its curvature is taken as if s were linear in the turn.
    """
    here = turn(e)
    sun = at.now.seen(here.attitude).sun
    loss = total(
        identity(p.panels.incidence_exponent * p.best_area + 0.0 * sun.x),
        scaled(_area_bend(sun, p), -1.0),
    )
    moved = times(skew(sun), here.small)
    shone = p.irradiance * at.now.light
    return scaled(times(transposed(moved), times(loss, moved)), shone)
