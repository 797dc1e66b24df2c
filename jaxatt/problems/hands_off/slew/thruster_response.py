"""Terminal errors of a slew with thrusters and their closed-form derivatives.

The errors of attitude, rate and momentum in body axes obey linear equations along the roll-out;
their adjoint, swept backwards with a Taylor step of second order an interval, gives the Jacobian of
the terminal rows for about the price of the roll-out itself.  Rows are exact, so Newton's method
with this Jacobian has the right fixed point, whatever the momentum.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude import quaternion
from jaxatt.problems.hands_off.slew.model import (
    SlewForm,
    SlewParameters,
    inertial_reference,
    rate_row,
)
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_rows, swing_slope
from jaxatt.simulation import external_model
from jaxatt.simulation.momentum_model import Components, cross, matvec

Row = tuple[Components, Components, Components]
"""Derivatives of one row with respect to the errors of attitude, rate and momentum."""


def body_torques(u: Array, p: SlewParameters) -> Array:
    """Torque on the wheels, then of the thrusters, in body axes, (N, 6) [N m]."""
    both = jnp.concatenate([p.to_body, p.to_external])
    # Not a product of matrices: elementwise, the batch axis stays where `vmap` has put it.
    torque = u[:, :1] * both[None, :, 0]
    for c in range(1, u.shape[1]):
        torque = torque + u[:, c, None] * both[None, :, c]
    return torque


def fly_thrusters(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Components, Array]:
    """Roll-out of scaled controls: last state (10), and states at nodes 1 to N, (N, 10)."""
    start = tuple(p.start[i] for i in range(7)) + tuple(p.momentum[i] for i in range(3))
    return external_model.rollout(start, body_torques(u, p), p.table, p.body, form.disturbed)


def _attitude_error(q: Array, p: SlewParameters) -> Array:
    """Error quaternion in inertial axes, (4,)."""
    return quaternion.multiply(q, quaternion.conjugate(inertial_reference(p)))


def _attitude_row(error: Array) -> Array:
    """Attitude error 4 sin(phi/4) about its axis, (3,), in inertial axes."""
    return 2.0 * error[1:] * jnp.sqrt(2.0 / jnp.maximum(1.0 + error[0], 1e-12))


def _attitude_slope(error: Array) -> Array:
    """Derivative (3, 3) of the attitude row with respect to a small turn in inertial axes."""
    eta, x, y, z = error[0], error[1], error[2], error[3]
    one = jnp.maximum(1.0 + eta, 1e-12)
    scale, rest = jnp.sqrt(2.0 / one), 0.5 / one
    return scale * jnp.stack(
        [
            jnp.stack([eta + rest * x * x, z + rest * x * y, -y + rest * x * z]),
            jnp.stack([-z + rest * x * y, eta + rest * y * y, x + rest * y * z]),
            jnp.stack([y + rest * x * z, -x + rest * y * z, eta + rest * z * z]),
        ]
    )


def terminal_errors(q: Array, omega: Array, p: SlewParameters) -> Array:
    """Attitude error, 4 sin(phi/4) about its inertial axis, and scaled rate error, (6,).

    Where the roll is free, the two errors of the boresight and that of the rate, (5,).
    """
    if p.held.shape[0] == 2:
        missed = attitude_rows(inertial_reference(p), q, p.held)
    else:
        missed = _attitude_row(_attitude_error(q, p))
    return jnp.concatenate([missed, rate_row(q, omega, p)])


def thruster_rows(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Terminal errors of scaled controls, as `terminal_errors`."""
    end, _ = fly_thrusters(u, p, form)
    return terminal_errors(jnp.stack(end[:4]), jnp.stack(end[4:7]), p)


def thruster_response(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """Terminal errors (m,) and their derivatives (N, m, b) for scaled controls u (N, b)."""
    end, nodes = fly_thrusters(u, p, form)
    history = jnp.concatenate([jnp.concatenate([p.start, p.momentum])[None], nodes])
    rows = terminal_errors(jnp.stack(end[:4]), jnp.stack(end[4:7]), p)
    if p.held.shape[0] == 2:
        slope = swing_slope(inertial_reference(p), jnp.stack(end[:4]), p.held)
    else:
        slope = _attitude_slope(_attitude_error(jnp.stack(end[:4]), p))
    return rows, _sweep(history, end, slope, p, u.shape[1])


def _rows_of(q: Components) -> list[Components]:
    """Rows of the body-to-inertial matrix."""
    w, x, y, z = q
    return [
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    ]


def _combined(shares: Components, rows: list[Components]) -> Components:
    """Sum of three rows, each times its factor."""
    return tuple(
        shares[0] * rows[0][c] + shares[1] * rows[1][c] + shares[2] * rows[2][c] for c in range(3)
    )


def through_interval(
    row: Row, before: Array, after: Array, p: SlewParameters, size: int
) -> tuple[Row, list[Array]]:
    """Propagate a row's derivatives with respect to the errors back over one interval.

    row : components of any shape.  before, after : (10,), states at both ends.
    Also returns its derivatives with respect to the interval's controls, `size` of them.
    """
    h, inverse = p.step, p.body.inverse_inertia
    middle = tuple(0.5 * (before[i] + after[i]) for i in range(4, 10))
    w, momentum = middle[:3], middle[3:]

    def through(row: Row) -> tuple[Row, Components]:
        """Row times the matrix of the error equations, and its derivative to external torque."""
        a, b, c = row
        d = tuple(x + y for x, y in zip(matvec(inverse, b), c, strict=True))  # J_s is symmetric
        rate = tuple(x + y for x, y in zip(a, cross(d, momentum), strict=True))
        return (cross(w, a), rate, cross(w, d)), d

    once, d0 = through(row)
    twice, d1 = through(once)
    _, d2 = through(twice)
    mean = tuple(h * (x + h * (y / 2.0 + h * z / 6.0)) for x, y, z in zip(d0, d1, d2, strict=True))
    body = [matvec(inverse, part[1]) for part in (row, once, twice)]
    wheel = tuple(-h * (x + h * (y / 2.0 + h * z / 6.0)) for x, y, z in zip(*body, strict=True))
    felt = [
        jnp.asarray(
            sum(mean[i] * p.to_external[i, c] + wheel[i] * p.to_body[i, c] for i in range(3))
        )
        for c in range(size)
    ]
    a, b, c = (
        tuple(x + h * (y + 0.5 * h * z) for x, y, z in zip(part, one, two, strict=True))
        for part, one, two in zip(row, once, twice, strict=True)
    )
    return (a, b, c), felt


def _sweep(history: Array, end: Components, slope: Array, p: SlewParameters, size: int) -> Array:
    """Derivatives (N, m, b) from the states at all nodes (N + 1, 10).

    slope : (3, 3), see `_attitude_slope`; (2, 3) where the roll is free.
    """
    zero = jnp.zeros((), history.dtype)
    nothing: Components = (zero, zero, zero)
    unit = [tuple(zero + float(i == j) for j in range(3)) for i in range(3)]
    turned = _rows_of(end[:4])
    first: list[Row] = [
        (_combined(tuple(slope[i, j] for j in range(3)), turned), nothing, nothing)
        for i in range(slope.shape[0])
    ]
    # The orbit frame turns too slowly for the attitude's share in the rate row to matter.
    first += [(nothing, tuple(RATE_SCALE * x for x in e), nothing) for e in unit]

    def backwards(rows: list[Row], stage: tuple[Array, Array]) -> tuple[list[Row], Array]:
        passed = [through_interval(row, *stage, p, size) for row in rows]
        return [row for row, _ in passed], jnp.stack([felt for _, part in passed for felt in part])

    _, entries = lax.scan(backwards, first, (history[:-1], history[1:]), reverse=True)
    return entries.reshape(history.shape[0] - 1, len(first), size)
