"""Closed-form derivatives of one interval of a slew, accurate to second order in the step.

In the error coordinates of `stages` an interval turns the attitude error with the body and
adds the integral of the rate error; momentum couples the two weakly.  Where the momentum is large
differentiate the dynamics instead.
"""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.hands_off.slew.model import SlewForm
from jaxatt.problems.hands_off.sparse_program import SparseArguments

Rows = list[list[Array]]


def _rotation(q: tuple[Array, ...]) -> Rows:
    """Rotation matrix of a quaternion given as four scalars."""
    w, x, y, z = q
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


def _turned_back(to: Array, q: Array) -> tuple[Array, ...]:
    """Product conj(to) q as four scalars."""
    a, b = to, q
    return (
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3],
        a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] + a[1] * b[3] - a[2] * b[0] - a[3] * b[1],
        a[0] * b[3] - a[1] * b[2] + a[2] * b[1] - a[3] * b[0],
    )


def _stacked(rows: Rows) -> Array:
    return jnp.stack([jnp.stack(row) for row in rows])


def _times(a: Array, b: Array) -> Array:
    """Matrix product of (3, 3) and (3, r)."""
    return a[:, :1] * b[:1] + a[:, 1:2] * b[1:2] + a[:, 2:] * b[2:]


def _cross_matrix(v: Array) -> Array:
    zero = jnp.zeros((), v.dtype)
    return _stacked([[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]])


def slew_derivatives(
    form: SlewForm,
) -> Callable[[Array, Array, Array, object, SparseArguments], Array]:
    """Function `linearise` of an `OptimalControlProgram`, for a slew of this form."""

    def derivatives(
        x: Array, u: Array, x_next: Array, stage: object, args: SparseArguments
    ) -> Array:
        p = args.plant
        h, inverse, dtype = p.step, p.body.inverse_inertia, x.dtype
        size = u.shape[0]
        turn = _stacked(_rotation(_turned_back(x_next, x)))
        to_body = _stacked(_rotation(tuple(x[i] for i in range(4)))).T
        momentum = x[7:10] if form.disturbed else p.momentum
        carried = jnp.sum(to_body * momentum[None], axis=1)
        rate = 0.5 * (x[4:7] + x_next[4:7])
        eye, zero = jnp.eye(3, dtype=dtype), jnp.zeros((3, 3), dtype)
        along = jnp.sum(carried * rate) * eye - carried[:, None] * rate[None]
        impulse = -h * inverse @ p.to_body
        attitude = [turn, 0.5 * h * (turn + eye)]
        speed = [
            h * _times(inverse, along),
            eye + h * _times(inverse, _cross_matrix(carried)),
        ]
        rows = [attitude, speed]
        if form.disturbed:
            carrying = -h * _times(inverse, _times(_cross_matrix(rate), to_body))
            attitude.append(0.5 * h * carrying)
            speed.append(carrying)
            rows.append([zero, zero, eye])
        if form.speed_limited:
            for row in rows:
                row.append(jnp.zeros((3, size), dtype))
            width = 3 * len(rows)
            rows.append([jnp.zeros((size, width), dtype), jnp.eye(size, dtype=dtype)])
        attitude.append(h * _times(turn / 6.0 + eye / 3.0, impulse))
        speed.append(impulse)
        if form.disturbed:
            rows[2].append(jnp.zeros((3, size), dtype))
        if form.speed_limited:
            rows[-1].append(h * jnp.eye(size, dtype=dtype))
        return jnp.concatenate([jnp.concatenate(row, axis=1) for row in rows])

    return derivatives
