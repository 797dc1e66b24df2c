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
from jaxatt.simulation.light_quadrature import shares_of
from jaxatt.simulation.powered_flight import Step, higher, lower
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

    def taken(self, torque: Vector) -> tuple[Array, ...]:
        """Torque of each wheel [N m] from that on all of them in body axes."""
        return tuple(jnp.asarray(share.dot(torque)) for share in self.shares)


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


class Turned(NamedTuple):
    """State of a turn between two intervals.

    speeds : of the wheels [rad/s].  momentum : A Jw omega_bw [N m s].
    """

    q_ib: Quaternion
    speeds: tuple[Array, ...]
    momentum: Vector


class TurnSpent(NamedTuple):
    """Energies [J] of an interval, torque [N m] and dipole [A m^2] where they were largest, and the
    lowest and the highest speed of each wheel [rad/s]."""

    solar: Array
    wheels: Array
    magnetorquers: Array
    torque: tuple[Array, ...]
    lowest: tuple[Array, ...]
    highest: tuple[Array, ...]
    strongest: Vector


def begin_turn(body: TurnedBody, q_ib: Quaternion, speeds: tuple[Array, ...]) -> Turned:
    """State before the first interval; speeds : (lanes,) [rad/s] of each wheel."""
    return Turned(q_ib, speeds, body.momentum(speeds, q_ib.eps))


def turn_interval(
    turning: Turning, powers: Powers, carried: Turned, steps: Step, step: Array
) -> tuple[Turned, TurnSpent]:
    """Fly one interval; steps : leading axis of the steps.  step : (lanes,) or (1,) [s]."""
    zero = jnp.zeros_like(jnp.asarray(carried.q_ib.eta))
    still = tuple(zero for _ in carried.speeds)
    lowest, highest = (tuple(zero + end for _ in still) for end in (jnp.inf, -jnp.inf))
    none = TurnSpent(zero, zero, zero, still, lowest, highest, Vector(zero, zero, zero))

    def advance(
        at: tuple[Turned, TurnSpent], around: Step
    ) -> tuple[tuple[Turned, TurnSpent], None]:
        return _step(turning, powers, *at, around, step), None

    return lax.scan(advance, (carried, none), steps)[0]


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
    turning: Turning, powers: Powers, at: Turned, spent: TurnSpent, around: Step, step: Array
) -> tuple[Turned, TurnSpent]:
    """Advance by one step and add what it earns and spends."""
    body = turning.body
    momentum = momentum_after(turning, at.q_ib, at.momentum, around.along, step)
    change = momentum - at.momentum
    after = Turned(
        turning.turned(at.q_ib, step).normalized(), body.changed(at.speeds, change), momentum
    )
    # At the Gauss points of the step.
    points = around.light.shape[0]
    shares = jnp.asarray(shares_of(points))[:, None]
    rowed = turning._replace(omega=_row(turning.omega))
    middle = jax.tree.map(lambda x: x[1][None], around.along)
    q_ib = rowed.turned(_row(at.q_ib), shares * step[None])
    within = _row(at.momentum) + shares * _row(change)
    taken = body.taken(rowed.on_wheels(q_ib, within, middle))
    speeds = body.changed(_row(at.speeds), shares * _row(change))
    moment = rowed.moment(q_ib, within, middle) or 0.0 * within
    weight = step / points
    sun_b = q_ib.rotate_inverse(_row(around.sun))
    return after, TurnSpent(
        spent.solar + jnp.sum(around.light * powers.solar(sun_b), axis=0),
        spent.wheels + weight * jnp.sum(powers.wheels(taken, speeds), axis=0),
        spent.magnetorquers + weight * jnp.sum(powers.magnetorquers(moment), axis=0),
        tuple(map(_larger, spent.torque, taken)),
        tuple(map(lower, spent.lowest, speeds)),
        tuple(map(higher, spent.highest, speeds)),
        spent.strongest.map(lambda most, m: jnp.abs(_larger(most, m)), moment),
    )


def _larger(most: Array, each: Array) -> Array:
    """Of a number () and several (k,), the one of the largest magnitude, with its sign."""
    for value in each:
        most = jnp.where(jnp.abs(value) > jnp.abs(most), value, most)
    return most


def _row(v: Any) -> Any:
    """The same with a leading axis of one, for the points within a step."""
    return jax.tree.map(lambda x: x[None], v)
