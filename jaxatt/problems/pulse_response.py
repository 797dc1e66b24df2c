"""What the torque of each interval does to the end of a slew, without differentiating anything.

Where the total momentum is small the gyroscopic terms hardly matter: an impulse changes the rate
by as much in body axes for good, and the attitude at the end by the integral of the body-to-
inertial rotation from then on.  That makes the Jacobian of the terminal rows a by-product of the
roll-out.  The rows themselves are exact, so a Newton iteration with this Jacobian has the right
fixed point; it contracts by about |H| T / J an iteration.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude import quaternion
from jaxatt.problems.slew import (
    RATE_SCALE,
    SlewForm,
    SlewParameters,
    fly_nodes,
    inertial_reference,
    inertial_waypoint,
    rate_row,
)
from jaxatt.simulation import momentum_model

Matrix = tuple[Array, ...]
"""Nine entries, row by row: components keep the batch contiguous, see `momentum_model`."""


def _rotation(q: Array) -> Matrix:
    """Body-to-inertial matrix of a quaternion (4,)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


def _attitude_error(reference: Array, q: Array) -> Array:
    """Rotation vector from the reference to q in inertial axes, (3,) [rad], of 0 to 2 pi."""
    error = quaternion.multiply(q, quaternion.conjugate(reference))
    return quaternion.to_rotation_vector(error)


def _derivatives(history: Array, impulse: Array, step: Array, nodes: list[Array]) -> Array:
    """Attitude change at each of `nodes` for a unit of every control, the rate change between.

    history : (N + 1, 4), q_ib at all nodes.  impulse : (3, b) [rad/s], rate change of a unit of
    the controls of an interval.  step : () [s].  nodes : () int each, the last node first.
    Returns (N, m, b): rows of the first node's attitude, of the rate, of the other nodes' attitude.
    """
    count, size = history.shape[0] - 1, impulse.shape[1]
    rate = [RATE_SCALE * impulse[i, c] for i in range(3) for c in range(size)]

    def backwards(
        carry: tuple[list[Matrix], Matrix], stage: tuple[Array, list[Array]]
    ) -> tuple[tuple[list[Matrix], Matrix], Array]:
        later, end = carry
        q, counts = stage
        begin = _rotation(q)
        rows: list[list[Array]] = []
        swept = []
        for since, counted in zip(later, counts, strict=True):
            h = counted * step
            own = [s + h * (a / 6.0 + b / 3.0) for s, a, b in zip(since, begin, end, strict=True)]
            swept.append(
                tuple(s + 0.5 * h * (a + b) for s, a, b in zip(since, begin, end, strict=True))
            )
            rows.append(
                [
                    own[3 * i] * impulse[0, c]
                    + own[3 * i + 1] * impulse[1, c]
                    + own[3 * i + 2] * impulse[2, c]
                    for i in range(3)
                    for c in range(size)
                ]
            )
        first, *others = rows
        return (swept, begin), jnp.stack([*first, *rate, *(x for row in others for x in row)])

    nothing: Matrix = (jnp.zeros((), history.dtype),) * 9
    start = ([nothing] * len(nodes), _rotation(history[-1]))
    counts = [(jnp.arange(count) < last).astype(history.dtype) for last in nodes]
    _, entries = lax.scan(backwards, start, (history[:-1], counts), reverse=True)
    return entries.reshape(count, -1, size)


def _rows(end: momentum_model.Components, nodes: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Errors of attitude (rotation vector in inertial axes) and rate, then at the waypoint."""
    q = jnp.stack(end[:4])
    rows = [_attitude_error(inertial_reference(p), q), rate_row(q, jnp.stack(end[4:]), p)]
    if form.has_waypoint:
        rows.append(_attitude_error(inertial_waypoint(p), nodes[p.waypoint_node - 1, :4]))
    return jnp.concatenate(rows)


def pulse_response(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """Terminal rows and their approximate derivatives, u : (N, b).

    Returns (m,) and (N, m, b): the errors of attitude (rotation vector in inertial axes) and rate
    at the last node, then of attitude at the waypoint; [rad], `RATE_SCALE` x [rad/s], [rad].
    """
    end, nodes = fly_nodes(u, p, form)
    history = jnp.concatenate([p.start[None, :4], nodes[:, :4]])
    impulse = -p.step * p.body.inverse_inertia @ p.to_body
    at = [jnp.asarray(u.shape[0]), *([p.waypoint_node] if form.has_waypoint else [])]
    return _rows(end, nodes, p, form), _derivatives(history, impulse, p.step, at)


def exact_response(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """As `pulse_response`, with the derivatives by differentiation: for large momentum."""

    def rows(controls: Array) -> Array:
        return _rows(*fly_nodes(controls, p, form), p, form)

    values, pullback = jax.vjp(rows, u)
    derivatives = jax.vmap(lambda row: pullback(row)[0])(jnp.eye(len(values), dtype=u.dtype))
    return values, jnp.swapaxes(derivatives, 0, 1)
