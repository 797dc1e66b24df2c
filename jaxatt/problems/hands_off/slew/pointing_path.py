"""Pointing limits along a roll-out at its nodes, with an allowance for the way between them."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters, fly_nodes, speed_margins
from jaxatt.problems.pointing.cones import PointingLimits, cone_margin, rate_margins


def node_margins(
    q_ib: Array, omega_ib: Array, directions: Array, step: Array, limits: PointingLimits
) -> Array:
    """Margins at one node as in `pointing_margins`, less the allowance for the way beside it.

    q_ib : (4,).  omega_ib : (3,) [rad/s].  directions : (m, 3), inertial.  step : () [s].

    The cosine of a cone's angle bends by f'' = (omega x (omega x b)) . d on a body that turns
    evenly, so within half a step of a node it passes the node's value by f'' step^2 / 8 at most.
    What a pulse adds to that inside its interval is left to the flights that judge the answer.
    """
    q, w = Quaternion.of(q_ib), Vector.of(omega_ib)

    def cone(_: None, inputs: tuple[Array, Array, Array, Array]) -> tuple[None, Array]:
        boresight, edge, sense, direction = inputs
        b, seen = Vector.of(boresight), q.rotate_inverse(Vector.of(direction))
        bend = sense * w.cross(w.cross(b)).dot(seen) * lax.rsqrt(1.0 - edge * edge)
        dip = jnp.maximum(0.0, bend) * step * step / 8.0
        return None, cone_margin(b.dot(seen), edge, sense) - dip

    # A loop keeps XLA from recomputing its straight-line code, as in `momentum_model`.
    each = (limits.boresights, limits.cosines, limits.senses, directions)
    cones = lax.scan(cone, None, each)[1]
    # The rate changes evenly inside an interval, so its ends are its extremes.
    rates = rate_margins(omega_ib, limits)
    return jnp.concatenate([cones, jnp.stack(rates)]) if rates else cones


def path_margins(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Margins of wheel speeds, cones and rates at nodes 1 to N, (p,), for u (N, b)."""
    speeds = speed_margins(u, p, form)
    if not form.pointed:
        return speeds
    return jnp.concatenate([speeds, pointing_rows(fly_nodes(u, p, form)[1], p)])


def pointing_rows(nodes: Array, p: SlewParameters) -> Array:
    """Margins of cones and rates at nodes 1 to N, flat; nodes (N, 7 or more)."""
    limits, toward = p.pointing.limits, p.pointing.directions[1:]
    rows = jax.vmap(lambda x, d: node_margins(x[:4], x[4:7], d, p.step, limits))(nodes, toward)
    return rows.ravel()
