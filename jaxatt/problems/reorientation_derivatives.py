"""One interval of a reorientation to second order, its attitude as a quaternion.

What an interval does to the attitude, q+ = q (x) dq, does not depend on q, and the Runge-Kutta step
keeps that: only dq and the rates need differentiating, by the rates, the controls and the length of
the interval.  First derivatives are exact.  The curvature is that of a coarser model of the
interval, dq = exp(h omega + h^2/2 omega'), right to a few per cent where gaps and momentum are
small: Newton's method then converges a little slower, to the same point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.problems.staged import Slopes
from jaxatt.simulation.free_body import BodyForm, derivative, step
from jaxatt.simulation.momentum_model import Components, cross

if TYPE_CHECKING:
    from jaxatt.problems.reorientation import ReorientationParameters

_IDENTITY = (1.0, 0.0, 0.0, 0.0)


def multiply(p: Components, q: Components) -> Components:
    """Product of quaternions."""
    u, v = p[1:], q[1:]
    w = p[0] * q[0] - u[0] * v[0] - u[1] * v[1] - u[2] * v[2]
    turned = cross(u, v)
    return (w, *(p[0] * v[i] + q[0] * u[i] + turned[i] for i in range(3)))


def _conjugate(q: Components) -> Components:
    return (q[0], -q[1], -q[2], -q[3])


def torques(p: ReorientationParameters, u: Array) -> Components:
    """Torque on the wheels and of the thrusters in body axes, six scalars [N m]."""
    both = (p.to_body, p.to_external)
    zero = jnp.zeros((), u.dtype)
    return tuple(
        sum((m[i, j] * u[j] for j in range(u.shape[0])), zero) for m in both for i in range(3)
    )


def _chart_slope(s: Components) -> list[list[Array]]:
    """Derivative of four times MRP s by a small turn in body axes, (3, 3)."""
    squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    none = jnp.zeros_like(squared)
    skew = [[none, -s[2], s[1]], [s[2], none, -s[0]], [-s[1], s[0], none]]
    return [
        [(1.0 - squared) * (i == j) + 2.0 * skew[i][j] + 2.0 * s[i] * s[j] for j in range(3)]
        for i in range(3)
    ]


def _rotation(q: Components) -> list[list[Array]]:
    """Matrix R(q)', from the old body axes to the new ones."""
    w, x, y, z = q
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


class IntervalDerivatives:
    """`StagedProgram.slopes` and `bending` of a reorientation with quaternions.

    impulses : controls whose impulse is a state.  size : b.
    """

    def __init__(self, body: BodyForm, impulses: int, size: int):
        self.body, self.impulses, self.size = body, impulses, size
        self.spin = body.size - 4
        """Rate and, where it is carried, momentum."""

    def _reduced(self, x: Array, u: Array) -> Array:
        """What an interval depends on: spin, controls, logarithm of the mean interval, (y,)."""
        return jnp.concatenate([x[4 : 4 + self.spin], u, x[-1:]])

    def _state(self, y: Array) -> Components:
        return tuple(jnp.asarray(c, y.dtype) for c in _IDENTITY) + tuple(
            y[i] for i in range(self.spin)
        )

    def _moved(self, y: Array, share: Array, p: ReorientationParameters) -> tuple[Array, Array]:
        """Turn (4,) and spin after an interval."""
        h = share * jnp.exp(y[-1])
        controls = y[self.spin : -1]
        end = step(self._state(y), torques(p, controls), h, p.body, self.body)
        return jnp.stack(end[:4]), jnp.stack(end[4:])

    def _row(self, turn: Array, by_y: Array, impulse: Array) -> Array:
        """A row in z: turn, spin, impulses, length, controls."""
        s = self.spin
        return jnp.concatenate([turn, by_y[:s], impulse, by_y[-1:], by_y[s:-1]])

    def slopes(
        self, x: Array, u: Array, x_next: Array, share: Array, p: ReorientationParameters
    ) -> Slopes:
        """See `StagedProgram.slopes`."""
        dtype, spin, impulses = x.dtype, self.spin, self.impulses
        y = self._reduced(x, u)
        (turned, spun), (turning, spinning) = jax.vmap(
            lambda direction: jax.jvp(lambda at: self._moved(at, share, p), (y,), (direction,)),
            in_axes=0,
            out_axes=((None, None), 0),
        )(jnp.eye(y.shape[0], dtype=dtype))
        dq = tuple(turned[i] for i in range(4))
        ahead = multiply(tuple(x[i] for i in range(4)), dq)
        missing = multiply(_conjugate(tuple(x_next[i] for i in range(4))), ahead)
        scale = 1.0 / jnp.maximum(1.0 + missing[0], 1e-6)
        sigma = tuple(scale * missing[i] for i in range(1, 4))
        h = share * jnp.exp(x[-1])
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
        flat, none = jnp.zeros(3, dtype), jnp.zeros(impulses, dtype)
        rows = []
        for i in range(3):
            by_turn = [sum(chart[i][k] * rotation[k][j] for k in range(3)) for j in range(3)]
            by_y = 2.0 * (chart[i][0] * rates[0] + chart[i][1] * rates[1] + chart[i][2] * rates[2])
            rows.append(self._row(jnp.stack(by_turn), by_y, none))
        rows += [self._row(flat, spinning[:, i], none) for i in range(spin)]
        for i in range(impulses):
            own = jnp.eye(self.size, dtype=dtype)[i]
            by_y = jnp.concatenate([jnp.zeros(spin, dtype), h * own, (h * u[i])[None]])
            rows.append(self._row(flat, by_y, own[:impulses]))
        last = jnp.eye(y.shape[0], dtype=dtype)[-1]
        rows.append(self._row(flat, last, none))
        spent = h * (1.0 + p.effort_weight * jnp.sum((p.scale * u) ** 2))
        by_control = 2.0 * h * p.effort_weight * p.scale**2 * u
        by_spin = jnp.zeros(spin, dtype)
        by_y = jnp.concatenate([by_spin, by_control, spent[None]])
        return Slopes(gap, jnp.stack(rows), self._row(flat, by_y, none))

    def _felt(self, y: Array, p: ReorientationParameters, weights: Array) -> Array:
        """Weighted sum of the derivatives of rate and momentum, ()."""
        torque = torques(p, y[self.spin : -1])
        slope = derivative(self._state(y), torque, p.body, self.body)[4:]
        return jnp.sum(weights * jnp.stack(slope))

    def bending(
        self,
        x: Array,
        u: Array,
        x_next: Array,
        share: Array,
        p: ReorientationParameters,
        costate: Array,
    ) -> Array:
        """See `StagedProgram.bending`.

        Of cost + by_turn . phi + by_spin . (spin + h spin') + by_impulse . h u, with the coarser
        turn phi = h omega + h^2/2 omega'; spin' is linear in the torques.
        """
        dtype, spin, impulses = x.dtype, self.spin, self.impulses
        y = self._reduced(x, u)
        h = share * jnp.exp(y[-1])
        omega = y[:3]
        slope = jnp.stack(derivative(self._state(y), torques(p, u), p.body, self.body)[4:])
        push = p.to_external - p.to_body
        by_torque = jnp.stack(
            [sum(p.body.inverse[i, k] * push[k] for k in range(3)) for i in range(3)]
        )
        force, whole = costate[:3], h * (omega + 0.5 * h * slope[:3])
        turning = force - 0.5 * _cross(force, whole)
        by_spin, by_impulse = costate[3 : 3 + spin], costate[3 + spin : -1]
        still = jnp.zeros(spin - 3, dtype)

        # By the logarithm of the interval and everything, itself first.
        spent = h * (1.0 + p.effort_weight * jnp.sum((p.scale * u) ** 2))
        moved = h * (jnp.sum(by_spin * slope) + jnp.sum(by_impulse * u[:impulses]))
        itself = spent + moved + jnp.sum(turning * (h * omega + 2.0 * h * h * slope[:3]))
        weights = h * by_spin + jnp.concatenate([h * h * turning, still])
        by_y = jax.grad(self._felt)(y, p, weights)
        direct = jnp.concatenate([h * turning, still])
        charged = 2.0 * h * p.effort_weight * p.scale**2
        driven = charged * u + jnp.pad(h * by_impulse, (0, self.size - impulses))
        none = jnp.zeros(impulses, dtype)
        edge = jnp.concatenate(
            [by_y[:spin] + direct, none, jnp.zeros(1, dtype), by_y[spin:-1] + driven]
        )
        at = (jnp.arange(edge.shape[0]) == spin + impulses).astype(dtype)
        rest = at[:, None] * edge[None] + edge[:, None] * at[None] + itself * at[:, None] * at[None]
        paid = jnp.concatenate([jnp.zeros(spin + impulses + 1, dtype), charged])
        rest = rest + paid[:, None] * jnp.eye(edge.shape[0], dtype=dtype)
        if self.body.momentum != "zero":
            weights = h * by_spin + jnp.concatenate([0.5 * h * h * turning, still])
            bent = jax.hessian(lambda part: self._felt(y.at[:spin].set(part), p, weights))(y[:spin])
            rest = rest + jnp.pad(bent, (0, edge.shape[0] - spin))
        # Two turns in succession: to second order their vectors add, and half their product; the
        # first one, the error of x, is turned on by the interval.
        by_rate = h * jnp.eye(3, spin, dtype=dtype)
        by_length = h * (omega + h * slope[:3])
        turned = jnp.concatenate(
            [by_rate, jnp.zeros((3, impulses), dtype), by_length[:, None], 0.5 * h * h * by_torque],
            axis=1,
        )
        crossed = -_cross(force, turned)
        side = 0.5 * (crossed + _cross(whole, crossed))
        return jnp.concatenate(
            [
                jnp.concatenate([jnp.zeros((3, 3), dtype), side], axis=1),
                jnp.concatenate([side.T, rest], axis=1),
            ]
        )


def _cross(a: Array, b: Array) -> Array:
    """Product of a vector (3,) with another or with the columns of a matrix, (3, ...)."""
    return jnp.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
