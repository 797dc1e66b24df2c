"""First and second derivatives of one interval of a reorientation, with quaternions.

What an interval does to the attitude, q+ = q (x) dq, does not depend on q, and the Runge-Kutta step
keeps that: only dq and the rates need differentiating, by the rates and the torque.  The length of
the interval needs none: with rates c times as large and torques c^2 times as large, a body passes
through the same attitudes in 1/c of the time.  First derivatives are exact.  The curvature is that
of a coarser model of the interval, dq = exp(h omega + h^2/2 omega'), right to a few per cent where
gaps and momentum are small: Newton's method then converges a little slower, to the same point.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.simulation.free_body import BodyForm, derivative, step
from jaxatt.simulation.momentum_model import Components, cross

_IDENTITY = (1.0, 0.0, 0.0, 0.0)


def multiply(p: Components, q: Components) -> Components:
    """Product of two quaternions."""
    u, v = p[1:], q[1:]
    w = p[0] * q[0] - u[0] * v[0] - u[1] * v[1] - u[2] * v[2]
    turned = cross(u, v)
    return (w, *(p[0] * v[i] + q[0] * u[i] + turned[i] for i in range(3)))


def _conjugate(q: Components) -> Components:
    return (q[0], -q[1], -q[2], -q[3])


def torques(p: ReorientationParameters, u: Array) -> Components:
    """Torque on the wheels and of the thrusters in body axes, six scalars [1/s^2]."""
    both = (p.to_body, p.to_external)
    zero = jnp.zeros((), u.dtype)
    return tuple(
        sum((m[i, j] * u[j] for j in range(u.shape[0])), zero) for m in both for i in range(3)
    )


def _chart_slope(s: Components) -> list[list[Array]]:
    """Derivative (3, 3) of four times MRP s with respect to a small turn in body axes."""
    squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    none = jnp.zeros_like(squared)
    skew = [[none, -s[2], s[1]], [s[2], none, -s[0]], [-s[1], s[0], none]]
    return [
        [(1.0 - squared) * (i == j) + 2.0 * skew[i][j] + 2.0 * s[i] * s[j] for j in range(3)]
        for i in range(3)
    ]


def _rotation(q: Components) -> list[list[Array]]:
    """Rotation matrix R(q)', from the old body axes to the new ones."""
    w, x, y, z = q
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


class IntervalDerivatives:
    """First and second derivatives of a reorientation with quaternions, for its programme.

    impulses : controls whose impulse is a state.  size : b.
    """

    def __init__(self, body: BodyForm, impulses: int, size: int):
        self.body, self.impulses, self.size = body, impulses, size
        self.spin = body.size - 4
        """Rate and, where it is carried, momentum."""

    def _state(self, spin: Array) -> Components:
        still = tuple(jnp.asarray(c, spin.dtype) for c in _IDENTITY)
        return still + tuple(spin[i] for i in range(self.spin))

    def _drive(self, p: ReorientationParameters, u: Array) -> Array:
        """Torque that drives an interval, or the controls themselves.

        The controls where wheels and thrusters act differently on the states that are carried.
        """
        if self.body.momentum == "carried":
            return u
        wheel_and_thrust = torques(p, u)
        return jnp.stack([wheel_and_thrust[3 + i] - wheel_and_thrust[i] for i in range(3)])

    def _by_controls(self, p: ReorientationParameters, by_drive: Array) -> Array:
        """Derivative (b,) with respect to the controls, from that by the drive."""
        if self.body.momentum == "carried":
            return by_drive
        push = p.to_external - p.to_body
        return by_drive[0] * push[0] + by_drive[1] * push[1] + by_drive[2] * push[2]

    def _torque(self, p: ReorientationParameters, drive: Array) -> Components:
        if self.body.momentum == "carried":
            return torques(p, drive)
        none = jnp.zeros((), drive.dtype)
        return (-drive[0], -drive[1], -drive[2], none, none, none)

    def _row(self, turn: Array, by_y: Array, impulse: Array, length: Array, u: Array) -> Array:
        """One row in z: turn, spin, impulses, length, controls."""
        return jnp.concatenate([turn, by_y[: self.spin], impulse, length[None], u])

    def linearisation(
        self, x: Array, u: Array, x_next: Array, share: Array, p: ReorientationParameters
    ) -> Linearisation:
        """See `OptimalControlProgram.linearisation`."""
        dtype, spin, impulses = x.dtype, self.spin, self.impulses
        h = share * jnp.exp(x[-1])
        y = jnp.concatenate([x[4 : 4 + spin], self._drive(p, u)])

        def moved(y: Array) -> tuple[Array, Array]:
            end = step(self._state(y), self._torque(p, y[spin:]), h, p.body, self.body)
            return jnp.stack(end[:4]), jnp.stack(end[4:])

        (turned, spun), (turning, spinning) = jax.vmap(
            lambda direction: jax.jvp(moved, (y,), (direction,)),
            in_axes=0,
            out_axes=((None, None), 0),
        )(jnp.eye(y.shape[0], dtype=dtype))
        dq = tuple(turned[i] for i in range(4))
        ahead = multiply(tuple(x[i] for i in range(4)), dq)
        missing = multiply(_conjugate(tuple(x_next[i] for i in range(4))), ahead)
        scale = 1.0 / jnp.maximum(1.0 + missing[0], 1e-6)
        sigma = tuple(scale * missing[i] for i in range(1, 4))
        first = 4 + spin
        gap = jnp.concatenate(
            [
                jnp.stack([4.0 * s for s in sigma]),
                spun - x_next[4:first],
                x[first:-1] + h * u[:impulses] - x_next[first:-1],
                x[-1:] - x_next[-1:],
            ]
        )
        chart = _chart_slope(sigma)
        rates = multiply(_conjugate(dq), tuple(turning[:, i] for i in range(4)))[1:]
        rotation = _rotation(dq)
        # By the logarithm of the length: rates and momentum go with its inverse, torques with the
        # inverse of its square.
        degree = jnp.concatenate([y[:spin], 2.0 * y[spin:]])
        flat, none, zero = jnp.zeros(3, dtype), jnp.zeros(impulses, dtype), jnp.zeros((), dtype)
        rows = []
        for i in range(3):
            by_turn = [sum(chart[i][k] * rotation[k][j] for k in range(3)) for j in range(3)]
            by_y = 2.0 * (chart[i][0] * rates[0] + chart[i][1] * rates[1] + chart[i][2] * rates[2])
            by_u = self._by_controls(p, by_y[spin:])
            rows.append(self._row(jnp.stack(by_turn), by_y, none, jnp.sum(degree * by_y), by_u))
        for i in range(spin):
            by_y = spinning[:, i]
            by_u = self._by_controls(p, by_y[spin:])
            rows.append(self._row(flat, by_y, none, jnp.sum(degree * by_y) - spun[i], by_u))
        nothing = jnp.zeros(spin, dtype)
        for i in range(impulses):
            own = jnp.eye(self.size, dtype=dtype)[i]
            rows.append(self._row(flat, nothing, own[:impulses], h * u[i], h * own))
        still = jnp.zeros(self.size, dtype)
        rows.append(self._row(flat, nothing, none, zero + 1.0, still))
        spent = h * (1.0 + p.effort_weight * jnp.sum((p.scale * u) ** 2))
        by_control = 2.0 * h * p.effort_weight * p.scale**2 * u
        return Linearisation(
            gap, jnp.stack(rows), self._row(flat, nothing, none, spent, by_control)
        )

    def lagrangian_hessian(
        self,
        x: Array,
        u: Array,
        x_next: Array,
        share: Array,
        p: ReorientationParameters,
        costate: Array,
        kept: object,
    ) -> Array:
        """See `OptimalControlProgram.lagrangian_hessian`.

        Of cost + by_turn . phi + by_spin . (spin + h spin') + by_impulse . h u, with the coarser
        turn phi = h omega + h^2/2 omega'; spin' is linear in the torques.  Entry by entry, because
        a matrix put together from blocks is slow to write.
        """
        spin, impulses, size = self.spin, self.impulses, self.size
        length = 3 + spin + impulses
        """Where the logarithm of the interval stands; the controls follow."""
        y = jnp.concatenate([x[4 : 4 + spin], u])
        h = share * jnp.exp(x[-1])

        def rate(y: Array) -> Components:
            return derivative(self._state(y), torques(p, y[spin:]), p.body, self.body)[4:]

        def felt(y: Array, weights: Array) -> Array:
            return jnp.sum(weights * jnp.stack(rate(y)))

        slope = rate(y)
        force = tuple(costate[i] for i in range(3))
        by_spin = [costate[3 + i] for i in range(spin)]
        by_impulse = [costate[3 + spin + i] for i in range(impulses)]
        omega = tuple(x[4 + i] for i in range(3))
        whole = tuple(h * (w + 0.5 * h * a) for w, a in zip(omega, slope[:3], strict=True))
        turning = [f - 0.5 * c for f, c in zip(force, cross(force, whole), strict=True)]

        def weights(of_turn: float) -> Array:
            """Weights of the derivatives of rate and momentum, with their share in the turn."""
            shares = [of_turn * h * h * t for t in turning] + [jnp.zeros_like(h)] * (spin - 3)
            return jnp.stack([h * b + s for b, s in zip(by_spin, shares, strict=True)])

        paid = [2.0 * h * p.effort_weight * p.scale[j] ** 2 for j in range(size)]
        spent = h + 0.5 * sum(paid[j] * u[j] ** 2 for j in range(size))
        moved = h * sum(b * a for b, a in zip(by_spin, slope, strict=True))
        driven = h * sum((by_impulse[j] * u[j] for j in range(impulses)), jnp.zeros_like(h))
        reached = sum(
            t * (h * w + 2.0 * h * h * a) for t, w, a in zip(turning, omega, slope[:3], strict=True)
        )
        by_y = jax.grad(felt)(y, weights(1.0))
        found = {(length, length): spent + moved + driven + reached}
        for i in range(spin):
            found[3 + i, length] = by_y[i] + (h * turning[i] if i < 3 else 0.0)
        for j in range(size):
            impulse = h * by_impulse[j] if j < impulses else 0.0
            found[length, length + 1 + j] = by_y[spin + j] + paid[j] * u[j] + impulse
            found[length + 1 + j, length + 1 + j] = paid[j]
        if self.body.momentum != "zero":
            bent = jax.hessian(lambda s: felt(jnp.concatenate([s, u]), weights(0.5)))(y[:spin])
            found |= {(3 + i, 3 + j): bent[i, j] for i in range(spin) for j in range(i, spin)}
        # Two turns in succession: to second order their vectors add, and half their product; the
        # first one, the error of x, is turned on by the interval.
        push = p.body.inverse @ (p.to_external - p.to_body)
        none = jnp.zeros_like(h)
        turned = {3 + i: tuple(h if k == i else none for k in range(3)) for i in range(3)}
        turned[length] = tuple(h * (w + h * a) for w, a in zip(omega, slope[:3], strict=True))
        for j in range(size):
            turned[length + 1 + j] = tuple(0.5 * h * h * push[i, j] for i in range(3))
        for at, column in turned.items():
            crossed = cross(column, force)
            again = cross(whole, crossed)
            found |= {(i, at): 0.5 * (crossed[i] + again[i]) for i in range(3)}
        width = range(length + 1 + size)
        entries = [found.get((min(i, j), max(i, j)), none) for i in width for j in width]
        return jnp.stack(entries).reshape(len(width), len(width))
