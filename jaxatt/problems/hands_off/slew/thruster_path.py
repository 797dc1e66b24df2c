"""Worst cone angles and body rates of a slew with thrusters, and their derivatives.

A limit is met everywhere if it is met where it is worst, so each asks for a few rows only: a cone
for the worst node of every third of the slew, a rate for its worst node.  Derivatives come from
the same adjoint as those of the terminal rows, begun at those nodes.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.state_manifold import retract
from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters
from jaxatt.problems.hands_off.slew.pointing_path import node_margins, pointing_rows
from jaxatt.problems.hands_off.slew.thruster_response import Row, fly_thrusters, through_interval
from jaxatt.simulation.momentum_model import Components

_PARTS = 3
"""Parts of the slew in each of which a cone's worst node is looked at."""


def _worst(margins: Array, count: int) -> tuple[Array, Array]:
    """Interval and column (K,) of the worst nodes; margins (N, m + 6) or (N, m), m = `count`."""
    nodes, columns = margins.shape
    index = jnp.arange(nodes)
    chosen, which = [], []
    for part in range(_PARTS):
        inside = (index * _PARTS) // nodes == part
        for i in range(count):
            chosen.append(jnp.argmin(jnp.where(inside, margins[:, i], jnp.inf)))
            which.append(jnp.asarray(i))
    for axis in range((columns - count) // 2):
        # Of both signs the one that is nearer to its limit.
        pair = jnp.stack([margins[:, count + axis], margins[:, count + 3 + axis]])
        place = jnp.argmin(pair.ravel())
        chosen.append(place % nodes)
        which.append(count + axis + 3 * (place // nodes))
    return jnp.stack(chosen), jnp.stack(which)


def thruster_margins(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Margins of cones and rates at nodes 1 to N, flat, for scaled controls u (N, b)."""
    if not form.pointed:
        return jnp.zeros((0,), u.dtype)
    return pointing_rows(fly_thrusters(u, p, form)[1], p)


def path_response(u: Array, p: SlewParameters, form: SlewForm) -> tuple[Array, Array]:
    """Worst margins (K,) for scaled controls u (N, b), and their derivatives (N, K, b)."""
    _, nodes = fly_thrusters(u, p, form)
    limits, toward = p.pointing.limits, p.pointing.directions[1:]

    def margins(x: Array, directions: Array) -> Array:
        return node_margins(x[:4], x[4:7], directions, p.step, limits)

    # Loops, where `vmap` would do as well: they compile several times faster.
    along = lax.map(lambda node: margins(*node), (nodes[:, :7], toward))
    at, column = _worst(along, limits.count)

    def row(chosen: tuple[Array, Array]) -> tuple[Array, Array]:
        place, column = chosen
        x, directions = nodes[place, :7], toward[place]

        def moved(error: Array) -> Array:
            return margins(retract(x, error), directions)[column]

        return jax.value_and_grad(moved)(jnp.zeros(6, u.dtype))

    values, slopes = lax.map(row, (at, column))
    history = jnp.concatenate([jnp.concatenate([p.start, p.momentum])[None], nodes])
    nothing = jnp.zeros(values.shape, u.dtype)
    none: Components = (nothing, nothing, nothing)
    start: Row = (none, none, none)

    def backwards(rows: Row, stage: tuple[Array, Array, Array]) -> tuple[Row, Array]:
        before, after, interval = stage
        begins = jnp.where(at == interval, 1.0, 0.0)
        a, b, c = rows
        turned = tuple(x + begins * slopes[:, i] for i, x in enumerate(a))
        rates = tuple(x + begins * slopes[:, 3 + i] for i, x in enumerate(b))
        ahead, felt = through_interval((turned, rates, c), before, after, p, u.shape[1])
        return ahead, jnp.stack(felt, axis=-1)

    stages = (history[:-1], history[1:], jnp.arange(u.shape[0]))
    _, derivatives = lax.scan(backwards, start, stages, reverse=True)
    return values, derivatives
