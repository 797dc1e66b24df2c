"""Flight with an attitude that is prescribed: the body turns at a constant rate in its own axes.

What is left to integrate is the momentum of the wheels, which take whatever torque that motion asks
for: from J omega + h changing by external torques alone, dh/dt = external - omega x (J omega + h).
The torque is shared among the wheels by their least-squares allocation.  Energies are integrated as
in `powered_flight`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Matrix, Quaternion, Vector, combination
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.simulation.dense_step import Dipole
from jaxatt.simulation.light_quadrature import SHARES, WEIGHTS
from jaxatt.simulation.powered_flight import Step
from jaxatt.simulation.powers import Powers
from jaxatt.simulation.rigid_step import Motion
from jaxatt.spacecraft.vehicle import Spacecraft

_AHEAD = (0.0, 0.5, 0.5, 1.0)


class TurnedBody(NamedTuple):
    """Inertia and wheels of a vehicle, in scalars.

    inertia, spin_inertia : J and A Jw A' [kg m^2].  axes : of the wheels.  shares : of a body
    torque that each wheel takes.  wheel_inertia : (n,) [kg m^2].
    """

    inertia: Matrix
    spin_inertia: Matrix
    axes: tuple[Vector, ...]
    shares: tuple[Vector, ...]
    wheel_inertia: Array

    def momentum(self, speeds: tuple[Array, ...], like: Vector) -> Vector:
        """A Jw omega_bw [N m s]; like : any vector of the lanes' shape."""
        spun = [self.wheel_inertia[k] * speed for k, speed in enumerate(speeds)]
        return combination(self.axes, spun, like)

    def changed(self, speeds: tuple[Array, ...], change: Vector) -> tuple[Array, ...]:
        """Speeds after the wheels took up a change of momentum [N m s]."""
        return tuple(
            jnp.asarray(speed + share.dot(change) / self.wheel_inertia[k])
            for k, (speed, share) in enumerate(zip(speeds, self.shares, strict=True))
        )


def turned_body(craft: Spacecraft) -> TurnedBody:
    """Convert a vehicle to scalars."""
    wheels, count = craft.wheels, craft.wheels.count
    axes, shares = jnp.asarray(wheels.axes), jnp.asarray(wheels.allocation)
    return TurnedBody(
        Matrix.of(jnp.asarray(craft.inertia)),
        Matrix.of(jnp.asarray(wheels.spin_inertia_body)),
        tuple(Vector.of(axes[:, k]) for k in range(count)),
        tuple(Vector.of(shares[k]) for k in range(count)),
        jnp.asarray(wheels.inertia),
    )


class Turning(NamedTuple):
    """What acts on a turn at a constant rate omega [rad/s], in body axes."""

    body: TurnedBody
    torques: ExternalTorques
    dipole: Dipole
    omega: Vector

    def on_wheels(self, q_ib: Quaternion, momentum: Vector, along: Along) -> Vector:
        """Torque [N m] that the wheels take up; momentum : A Jw omega_bw [N m s]."""
        external = self.torques.total(
            q_ib, self.omega, along, self.body.inertia, self.moment(q_ib, momentum, along)
        )
        return external - self.omega.cross(self.body.inertia @ self.omega + momentum)

    def moment(self, q_ib: Quaternion, momentum: Vector, along: Along) -> Vector | None:
        """Dipole [A m^2] of the magnetorquers."""
        spun = momentum + self.body.spin_inertia @ self.omega
        return self.dipole(Motion(q_ib, self.omega), spun, along)

    def turned(self, q_ib: Quaternion, time: Array) -> Quaternion:
        """Attitude after a time [s]."""
        size = self.omega.norm()
        half = 0.5 * time * size
        still = size == 0.0
        per_rate = jnp.where(still, 0.5 * time, jnp.sin(half) / jnp.where(still, 1.0, size))
        return q_ib.multiply(Quaternion(jnp.cos(half), self.omega * per_rate))


class Carried(NamedTuple):
    """State between two steps.

    Since the interval began: energies [J], and torque [N m], speed [rad/s] and dipole [A m^2] where
    they were largest.
    """

    q_ib: Quaternion
    momentum: Vector
    speeds: tuple[Array, ...]
    solar: Array
    wheels: Array
    magnetorquers: Array
    torque: tuple[Array, ...]
    fastest: tuple[Array, ...]
    strongest: Vector


class TurnInterval(NamedTuple):
    """One row of a series: states at the end of an interval, and of the interval its energies [J],
    and torque [N m], speed [rad/s] and dipole [A m^2] where they were largest."""

    q_ib: Quaternion
    speeds: tuple[Array, ...]
    solar: Array
    wheels: Array
    magnetorquers: Array
    torque: tuple[Array, ...]
    fastest: tuple[Array, ...]
    strongest: Vector


def begin_turn(body: TurnedBody, q_ib: Quaternion, speeds: tuple[Array, ...]) -> Carried:
    """State before the first step; speeds : (lanes,) [rad/s] of each wheel."""
    zero = jnp.zeros_like(jnp.asarray(q_ib.eta))
    none = Vector(zero, zero, zero)
    still = tuple(zero for _ in speeds)
    momentum = body.momentum(speeds, none)
    return Carried(q_ib, momentum, speeds, zero, zero, zero, still, still, none)


def turn_interval(
    turning: Turning, powers: Powers, carried: Carried, steps: Step, step: Array
) -> tuple[Carried, TurnInterval]:
    """Fly one interval; steps : leading axis of the steps.  step : (lanes,) or (1,) [s]."""
    fresh = begin_turn(turning.body, carried.q_ib, carried.speeds)

    def advance(at: Carried, surroundings: Step) -> tuple[Carried, None]:
        return _step(turning, powers, at, surroundings, step), None

    after, _ = lax.scan(advance, fresh, steps)
    return after, TurnInterval(after.q_ib, *after[2:])


def momentum_after(
    turning: Turning, q_ib: Quaternion, momentum: Vector, along: Along, step: Array
) -> Vector:
    """Momentum of the wheels [N m s] after a Runge-Kutta step; along : (4, ...), at its stages."""

    def stage(carry: tuple[Vector, Vector], inputs: Any) -> tuple[tuple[Vector, Vector], None]:
        point, total = carry
        elapsed, ahead, weight, environment = inputs
        at = turning.turned(q_ib, elapsed * step)
        slope = turning.on_wheels(at, point, environment)
        return (momentum + ahead * step * slope, total + weight * step * slope), None

    coefficients = (_AHEAD, (0.5, 0.5, 1.0, 0.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6))
    inputs = (*(jnp.asarray(c) for c in coefficients), along)
    like = jax.tree.map(lambda h: jnp.broadcast_to(h, jnp.shape(q_ib.eta)), momentum)
    (_, end), _ = lax.scan(stage, (like, like), inputs)
    return end


def _step(
    turning: Turning, powers: Powers, at: Carried, surroundings: Step, step: Array
) -> Carried:
    """Advance by one step and add what it earns and spends."""
    after = momentum_after(turning, at.q_ib, at.momentum, surroundings.along, step)
    change = after - at.momentum
    shares = jnp.asarray(SHARES)[:, None]
    middle = jax.tree.map(lambda x: x[1][None], surroundings.along)
    rowed = turning._replace(omega=_row(turning.omega))
    q_ib = rowed.turned(_row(at.q_ib), shares * step[None])
    momentum = _row(at.momentum) + shares * _row(change)
    torque = rowed.on_wheels(q_ib, momentum, middle)
    body = turning.body
    taken = tuple(jnp.asarray(share.dot(torque)) for share in body.shares)
    speeds = body.changed(tuple(s[None] for s in at.speeds), momentum - _row(at.momentum))
    weights = jnp.asarray(WEIGHTS)[:, None] * step[None]
    sun_b = q_ib.rotate_inverse(_row(surroundings.sun))
    moment = rowed.moment(q_ib, momentum, middle)
    spent = at.magnetorquers
    strongest = at.strongest
    if moment is not None:
        spent = spent + jnp.sum(weights * powers.magnetorquers(moment), axis=0)
        strongest = strongest.map(
            lambda most, m: jnp.maximum(most, jnp.max(jnp.abs(m), axis=0)), moment
        )
    return Carried(
        q_ib=turning.turned(at.q_ib, step).normalized(),
        momentum=after,
        speeds=body.changed(at.speeds, change),
        solar=at.solar + jnp.sum(surroundings.light * powers.solar(sun_b), axis=0),
        wheels=at.wheels + jnp.sum(weights * powers.wheels(taken, speeds), axis=0),
        magnetorquers=spent,
        torque=tuple(_larger(most, each) for most, each in zip(at.torque, taken, strict=True)),
        fastest=tuple(
            jnp.maximum(most, jnp.max(jnp.abs(speed), axis=0))
            for most, speed in zip(at.fastest, speeds, strict=True)
        ),
        strongest=strongest,
    )


def _larger(most: Array, each: Array) -> Array:
    """Of a number () and several (k,), the one of the largest magnitude, with its sign."""
    for value in each:
        most = jnp.where(jnp.abs(value) > jnp.abs(most), value, most)
    return most


def _row(v: Any) -> Any:
    """The same with a leading axis of one, for the points within a step."""
    return jax.tree.map(lambda x: x[None], v)
