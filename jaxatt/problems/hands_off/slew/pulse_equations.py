"""Linearised terminal errors of a slew in one pass, without automatic differentiation.

Where the total momentum is small the gyroscopic terms hardly matter: an impulse changes the rate
by as much in body axes for good, and the attitude at the end by the integral of the body-to-
inertial rotation from then on, which is its whole integral less what has passed.  So the sums over
all intervals that a step of least weighted norm asks for can be taken on the way.  The rows are
exact in the end, so a Newton iteration has the right fixed point; it contracts by about |H| T / J
an iteration.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.equations import Equations
from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters, inertial_reference
from jaxatt.problems.hands_off.slew.response import flown_states, rows_at
from jaxatt.problems.terminal_rows import RATE_SCALE, swing_slope
from jaxatt.simulation.momentum_model import Components
from jaxatt.simulation.turn_model import turn

Row = tuple[Array, Array, Array]
"""A row of a matrix of three columns: components keep the batch contiguous, see `rollout`."""


def _rotation(q: Components) -> tuple[Row, ...]:
    """Body-to-inertial matrix of a quaternion, as three rows."""
    w, x, y, z = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def _sum(terms: Iterable[Array]) -> Array:
    return functools.reduce(operator.add, terms)


def _dot(a: Sequence[Array], b: Sequence[Array]) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _added(a: tuple[Array, ...], b: Iterable[Array]) -> tuple[Array, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))


def _stacked(rows: Sequence[Sequence[Array]]) -> Array:
    return jnp.stack([jnp.stack(list(row)) for row in rows])


def _product(a: Array, b: Array) -> Array:
    """Product of a matrix of three columns and another, elementwise over the batch."""
    return _sum(a[:, k, None] * b[None, k] for k in range(3))


class _Sums(NamedTuple):
    """Sums that one pass along the slew accumulates.

    An interval's impulse v changes the rate, and all of the attitude's integral but what passed
    before it: P v, one P for the end and one for the waypoint.  With Z = (1, P, ..) as rows:

    state : at the end, seven scalars.  whole : (3, 3) integral [s] of the rotation, one a P.
    reached : scalars, sum of Z v over the part that moved.
    moments : scalars, lower triangle of the sum of Z (spread of v) Z', row by row.
    history : (N, 9 ..), the rows of every P, then q_ib (4) where there is a waypoint.
    """

    state: Components
    whole: list[Array]
    reached: tuple[Array, ...]
    moments: tuple[Array, ...]
    history: Array

    def first(self, a: int) -> Array:
        """Block a of `reached`, (3,)."""
        return jnp.stack(self.reached[3 * a : 3 * a + 3])

    def second(self, a: int, b: int) -> Array:
        """Block (a, b) of `moments`, a >= b, (3, 3)."""
        places = [[(3 * a + r, 3 * b + c) for c in range(3)] for r in range(3)]
        index = [[max(x) * (max(x) + 1) // 2 + min(x) for x in row] for row in places]
        return _stacked([[self.moments[k] for k in row] for row in index])


def _changes(impulse: Array, row: Array) -> Row:
    x, y, z = (_sum(impulse[i, c] * row[c] for c in range(row.shape[0])) for i in range(3))
    return x, y, z


def _sweep(
    u: Array, weights: Array, moved: Array, impulse: Array, p: SlewParameters, form: SlewForm
) -> _Sums:
    count, size = u.shape
    blocks = 1 + form.has_waypoint
    rows = 3 + 3 * blocks
    momentum = tuple(p.momentum[i] for i in range(3))

    def interval(carry: Any, inputs: Any) -> tuple[Any, Array]:
        state, begin, passed, reached, moments = carry
        control, weight, part, counts, h = inputs
        state = turn(state, momentum, _changes(impulse, control), h, p.body.inverse_inertia)
        end = _rotation(state[:4])
        # Of an interval's impulse the rate has what is left of it: at once none, at its end all.
        before, after = [], []
        for block in range(blocks):
            length = h if block == 0 else h * counts
            for s, a, b in zip(passed[3 * block : 3 * block + 3], begin, end, strict=True):
                before.append(tuple(s[j] + length * (a[j] / 3.0 + b[j] / 6.0) for j in range(3)))
                after.append(tuple(s[j] + 0.5 * length * (a[j] + b[j]) for j in range(3)))
        spread = [
            [_sum(impulse[i, c] * impulse[j, c] * weight[c] for c in range(size)) for j in range(3)]
            for i in range(3)
        ]
        spread += [[_dot(row, column) for column in spread] for row in before]
        changed = _changes(impulse, part)
        reached = _added(reached, (*changed, *(_dot(row, changed) for row in before)))
        lower = (
            spread[r][c] if c < 3 else _dot(spread[r], before[c - 3])
            for r in range(rows)
            for c in range(r + 1)
        )
        out = [x for row in before for x in row] + list(state[:4] if form.has_waypoint else ())
        return (state, end, tuple(after), reached, _added(moments, lower)), jnp.stack(out)

    zero = jnp.zeros((), u.dtype)
    start = tuple(p.start[i] for i in range(7))
    nothing = ((zero,) * 3,) * (3 * blocks), (zero,) * rows, (zero,) * (rows * (rows + 1) // 2)
    counts = (jnp.arange(count) < p.waypoint_node).astype(u.dtype)
    lengths = jnp.broadcast_to(p.step, (count,))
    (state, _, total, reached, moments), history = lax.scan(
        interval, (start, _rotation(start[:4]), *nothing), (u, weights, moved, counts, lengths)
    )
    whole = [_stacked(total[3 * block : 3 * block + 3]) for block in range(blocks)]
    return _Sums(state, whole, reached, moments, history)


def _matrix(sums: _Sums) -> Array:
    """Matrix J diag(weights) J' for the rows: attitude, rate, attitude at the waypoint."""
    whole, rates = sums.whole, sums.second(0, 0)
    left = [_product(t, rates) - sums.second(a + 1, 0) for a, t in enumerate(whole)]

    def attitude(a: int, b: int) -> Array:
        if a < b:
            return attitude(b, a).T
        crossed = _product(sums.second(a + 1, 0), whole[b].T)
        return _product(whole[a], _product(rates, whole[b].T) - sums.second(b + 1, 0).T) - (
            crossed - sums.second(a + 1, b + 1)
        )

    def block(a: int | None, b: int | None) -> Array:
        if a is None:
            return RATE_SCALE**2 * rates if b is None else RATE_SCALE * left[b].T
        return RATE_SCALE * left[a] if b is None else attitude(a, b)

    order = [0, None, *range(1, len(whole))]
    return jnp.concatenate([jnp.concatenate([block(a, b) for b in order], axis=1) for a in order])


def pulse_equations(
    u: Array,
    weights: Array,
    moved: Array,
    accurate: Array,
    p: SlewParameters,
    form: SlewForm,
) -> Equations:
    """Rows of `response_rows` at u (N, b), linearised for a weighted least-norm step.

    weights, moved : (N, b).  accurate : () bool, whether the rows must be exact; otherwise those
    of `turn_model` will do, where no external torque acts.
    """
    step = jnp.broadcast_to(p.step, u.shape[:1])[0]  # what fills a programme up has no torque
    impulse = -step * p.body.inverse_inertia @ p.to_body
    sums = _sweep(u, weights, moved, impulse, p, form)
    whole, history = sums.whole, sums.history

    def pullback(shares: Array) -> Array:
        attitude, rate, *others = (shares[k : k + 3] for k in range(0, len(shares), 3))
        columns = [RATE_SCALE * rate[j] for j in range(3)]
        for block, share in enumerate([attitude, *others]):
            for j in range(3):
                ahead = (whole[block][r, j] - history[:, 9 * block + 3 * r + j] for r in range(3))
                columns[j] = columns[j] + _sum(share[r] * x for r, x in enumerate(ahead))
        back = [_sum(columns[i] * impulse[i, c] for i in range(3)) for c in range(u.shape[1])]
        return jnp.stack(back, axis=1)

    def exactly(controls: Array) -> tuple[Array, Array]:
        return flown_states(controls, p, form)

    if form.disturbed:
        states = exactly(u)
    else:
        passing = history[p.waypoint_node - 1, -4:] if form.has_waypoint else history[0, :0]
        roughly = jnp.stack(sums.state), passing
        states = lax.cond(accurate, exactly, lambda _: roughly, u)
    rows = rows_at(states, p, form)

    change, matrix = sums.first(0), _matrix(sums)
    ahead = [
        _sum(t[:, k] * change[k] for k in range(3)) - sums.first(a + 1) for a, t in enumerate(whole)
    ]
    reached = jnp.concatenate([ahead[0], RATE_SCALE * change, *ahead[1:]])
    if p.held.shape[0] == 3:
        return Equations(rows, matrix, reached, pullback)
    # Of the turn at the end, only what moves the boresight.
    slope = swing_slope(inertial_reference(p), states[0][:4], p.held)

    def kept(errors: Array) -> Array:
        return jnp.concatenate([_product(slope, errors[:3]), errors[3:]])

    def given(shares: Array) -> Array:
        turn = slope[0] * shares[0] + slope[1] * shares[1]
        return pullback(jnp.concatenate([turn, shares[2:]]))

    return Equations(rows, kept(kept(matrix).T), kept(reached[:, None])[:, 0], given)
