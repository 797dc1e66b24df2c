"""Terminal errors of a slew and their exact derivatives with respect to the controls.

The derivatives of all intervals are taken side by side, each at its own node, and multiplied
together from the last one backwards.
"""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude import quaternion
from jaxatt.environment.table import Environment
from jaxatt.problems.hands_off.slew.model import (
    SlewForm,
    SlewParameters,
    body_torque,
    fly_nodes,
    inertial_reference,
    inertial_waypoint,
    rate_row,
)
from jaxatt.problems.terminal_rows import attitude_rows
from jaxatt.simulation import momentum_model


def attitude_error(reference: Array, q: Array) -> Array:
    """Rotation vector (3,) [rad] from the reference to q in inertial axes, of 0 to 2 pi."""
    error = quaternion.multiply(q, quaternion.conjugate(reference))
    return quaternion.to_rotation_vector(error)


def end_rows(end: Array, p: SlewParameters) -> Array:
    """Errors of attitude [rad] and rate, `RATE_SCALE` x [rad/s], of a last state (7 or 10,)."""
    q, reference = end[:4], inertial_reference(p)
    free = p.held.shape[0] == 2
    missed = attitude_rows(reference, q, p.held) if free else attitude_error(reference, q)
    return jnp.concatenate([missed, rate_row(q, end[4:7], p)])


def passing_rows(q: Array, p: SlewParameters) -> Array:
    """Error of an attitude q_ib at the waypoint's node, (3,) [rad]."""
    return attitude_error(inertial_waypoint(p), q)


def flown_states(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """Attitude and rate at the last node, (7,), and attitude at the waypoint, (4,) or (0,)."""
    end, nodes = fly_nodes(u, p, form)
    passing = nodes[p.waypoint_node - 1, :4] if form.has_waypoint else jnp.zeros((0,), u.dtype)
    return jnp.stack(end[:7]), passing


def rows_at(states: tuple[Array, Array], p: SlewParameters, form: SlewForm) -> Array:
    """Errors at the last node, then of attitude at the waypoint, (6,) or (9,); one less where the
    roll is free.

    states : as `flown_states` returns them.
    """
    rows = end_rows(states[0], p)
    return jnp.concatenate([rows, passing_rows(states[1], p)]) if form.has_waypoint else rows


def response_rows(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Errors (m,) of scaled controls u (N, b), as `rows_at`."""
    return rows_at(flown_states(u, p, form), p, form)


def slew_response(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """Rows (m,) of `response_rows` and their exact derivatives (N, m, b); u : (N, b)."""
    end, nodes = fly_nodes(u, p, form)
    momentum = tuple(p.momentum[i] for i in range(3))
    first = jnp.concatenate([p.start, p.momentum]) if form.disturbed else p.start
    states = jnp.concatenate([first[None], nodes[:-1]])
    size = states.shape[1]

    def interval(x: Array, torque: Array, along: Environment, h: Array) -> Array:
        state, tau = tuple(x[i] for i in range(size)), tuple(torque[i] for i in range(3))
        return jnp.stack(
            momentum_model.step(state, momentum, tau, along, h, p.body, form.disturbed)
        )

    def differentiated(x: Array, torque: Array, along: Environment, h: Array) -> Array:
        def slope(way: Array) -> Array:
            tangents = way[:size], way[size:]
            return jax.jvp(lambda y, tau: interval(y, tau, along, h), (x, torque), tangents)[1]

        return jax.vmap(slope, in_axes=1, out_axes=1)(jnp.eye(size + 3, dtype=u.dtype))

    stages = momentum_model.with_down(p.table.stages)
    h = jnp.broadcast_to(p.table.substep, u.shape[:1])
    slopes = jax.vmap(differentiated)(states, body_torque(u, p), stages, h)

    last, rows = _sloped(lambda x: end_rows(x, p), jnp.stack(end))
    passing, injected = jnp.zeros((0, size), u.dtype), jnp.zeros(len(states), u.dtype)
    if form.has_waypoint:
        node = nodes[p.waypoint_node - 1]
        passing, missed = _sloped(lambda x: passing_rows(x[:4], p), node)
        rows = jnp.concatenate([rows, missed])
        passing = jnp.concatenate([jnp.zeros_like(last), passing])
        last = jnp.concatenate([last, jnp.zeros((3, size), u.dtype)])
        injected = (jnp.arange(1, len(states) + 1) == p.waypoint_node).astype(u.dtype)

    def backwards(later: Array, inputs: tuple[Array, Array]) -> tuple[Array, Array]:
        slope, here = inputs
        if form.has_waypoint:
            later = later + here * passing
        # Not a product of matrices: elementwise, the batch axis stays where `vmap` has put it.
        swept = later[:, :1] * slope[:1]
        for k in range(1, size):
            swept = swept + later[:, k, None] * slope[None, k]
        return swept[:, :size], swept[:, size:]

    _, by_torque = lax.scan(backwards, last, (slopes, injected), reverse=True)
    return rows, by_torque @ p.to_body


def _sloped(function: Callable[[Array], Array], x: Array) -> tuple[Array, Array]:
    """Derivatives (m, n) of a function at x (n,), and its values (m,) from the same pass."""

    def twice(y: Array) -> tuple[Array, Array]:
        value = function(y)
        return value, value

    slope, value = jax.jacfwd(twice, has_aux=True)(x)
    return slope, value
