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

import jax
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

Columns = tuple[tuple[Array, ...], ...]
"""Three rows of a matrix with a column for each control."""


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


def _scaled(row: Sequence[Array], weight: Array) -> tuple[Array, ...]:
    return tuple(x * weight[c] for c, x in enumerate(row))


def _dot(row: Sequence[Array], other: Sequence[Array] | Array) -> Array:
    return _sum(x * other[c] for c, x in enumerate(row))


def _stacked(rows: Sequence[Sequence[Array]]) -> Array:
    return jnp.stack([jnp.stack(list(row)) for row in rows])


def _product(a: Array, b: Array) -> Array:
    """Product of two matrices, elementwise over the batch."""
    return _sum(a[:, k, None] * b[None, k] for k in range(len(b)))


def _turned(q: Components, impulse: Array) -> Columns:
    """Impulses (3, b) from body to inertial axes."""
    ways = [[impulse[i, c] for i in range(3)] for c in range(impulse.shape[1])]
    return tuple(tuple(_dot(row, way) for way in ways) for row in _rotation(q))


class _Sums(NamedTuple):
    """Sums that one pass along the slew accumulates.

    A control of an interval turns the end by the integral of its impulse in inertial axes, the
    whole one less what had passed by then, q, (3, b).  There is one q for the end and one for the
    waypoint; what follows is a tuple over these, or over their pairs (a, b), b <= a.

    state : at the end, seven scalars.  whole : (3, b) [s rad/s], the integrals.
    weight, moved : (b,), sums of the weights and of what moved.
    first : (3, b), sums of q weight.  second : (3, 3), sums of q weight q'.
    reached : (3,), sums of q x what moved.
    history : (N, 3 b ..), every q, then q_ib (4) where there is a waypoint.
    """

    state: Components
    whole: tuple[Array, ...]
    weight: Array
    moved: Array
    first: tuple[Array, ...]
    second: tuple[Array, ...]
    reached: tuple[Array, ...]
    history: Array


def _sweep(
    u: Array, weights: Array, moved: Array, impulse: Array, p: SlewParameters, form: SlewForm
) -> _Sums:
    count, size = u.shape
    targets = 1 + form.has_waypoint
    momentum = tuple(p.momentum[i] for i in range(3))

    def interval(carry: Any, inputs: Any) -> tuple[Any, Array]:
        state, begin, passed, sums = carry
        control, weight, part, counts, h = inputs
        change = tuple(_dot([control[c] for c in range(size)], row) for row in impulse)
        state = turn(state, momentum, change, h, p.body.inverse_inertia)
        end = _turned(state[:4], impulse)
        # Of an interval's impulse the rate has what is left of it: at once none, at its end all.
        before, after = [], []
        for target, columns in enumerate(passed):
            length = h if target == 0 else h * counts
            part_of = (columns, begin, end)
            before.append(
                jax.tree.map(lambda s, a, b, x=length: s + x * (a / 3.0 + b / 6.0), *part_of)
            )
            after.append(jax.tree.map(lambda s, a, b, x=length: s + 0.5 * x * (a + b), *part_of))
        weighted = [tuple(_scaled(row, weight) for row in q) for q in before]
        terms = (
            tuple(weight[c] for c in range(size)),
            tuple(part[c] for c in range(size)),
            tuple(weighted),
            tuple(
                tuple(tuple(_dot(x, y) for y in before[b]) for x in weighted[a])
                for a, b in _pairs(targets)
            ),
            tuple(tuple(_dot(row, part) for row in q) for q in before),
        )
        out = [x for q in before for row in q for x in row]
        out += state[:4] if form.has_waypoint else ()
        return (state, end, tuple(after), jax.tree.map(jnp.add, sums, terms)), jnp.stack(out)

    zero = jnp.zeros((), u.dtype)
    few, three = (zero,) * size, (zero,) * 3
    start, tables = tuple(p.start[i] for i in range(7)), ((few,) * 3,) * targets
    squares = ((three,) * 3,) * len(_pairs(targets))
    nothing = (few, few, tables, squares, (three,) * targets)
    counts = (jnp.arange(count) < p.waypoint_node).astype(u.dtype)
    lengths = jnp.broadcast_to(p.step, (count,))
    (state, _, whole, sums), history = lax.scan(
        interval,
        (start, _turned(start[:4], impulse), tables, nothing),
        (u, weights, moved, counts, lengths),
    )
    weight, shifted, first, second, reached = sums
    return _Sums(
        state,
        tuple(_stacked(x) for x in whole),
        jnp.stack(weight),
        jnp.stack(shifted),
        tuple(_stacked(x) for x in first),
        tuple(_stacked(x) for x in second),
        tuple(jnp.stack(x) for x in reached),
        history,
    )


def _pairs(count: int) -> list[tuple[int, int]]:
    return [(a, b) for a in range(count) for b in range(a + 1)]


def _matrix(sums: _Sums, rate: Array) -> Array:
    """Matrix J diag(weights) J' for the rows: attitude, rate, attitude at the waypoint.

    rate : (3, b), change of the rate's rows by a unit of each control.
    """
    count = len(sums.whole)
    second = dict(zip(_pairs(count), sums.second, strict=True))
    weighed = [
        whole * sums.weight[None] - first
        for whole, first in zip(sums.whole, sums.first, strict=True)
    ]

    def attitudes(a: int, b: int) -> Array:
        if a < b:
            return attitudes(b, a).T
        crossed = _product(sums.whole[a], sums.first[b].T)
        return _product(weighed[a], sums.whole[b].T) - crossed + second[a, b]

    def block(a: int | None, b: int | None) -> Array:
        if a is None:
            return _product(rate * sums.weight[None], rate.T) if b is None else block(b, a).T
        return _product(weighed[a], rate.T) if b is None else attitudes(a, b)

    order = [0, None, *range(1, count)]
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
    rate = RATE_SCALE * impulse
    sums = _sweep(u, weights, moved, impulse, p, form)
    history = sums.history

    def pullback(shares: Array) -> Array:
        attitude, turning, *others = (shares[k : k + 3] for k in range(0, len(shares), 3))
        back = _sum(turning[i] * rate[i] for i in range(3))[None]
        for target, share in enumerate([attitude, *others]):
            for i in range(3):
                first = (3 * target + i) * u.shape[1]
                passed = history[:, first : first + u.shape[1]]
                back = back + share[i] * (sums.whole[target][i][None] - passed)
        return back

    def exactly(controls: Array) -> tuple[Array, Array]:
        return flown_states(controls, p, form)

    if form.disturbed:
        states = exactly(u)
    else:
        passing = history[p.waypoint_node - 1, -4:] if form.has_waypoint else history[0, :0]
        roughly = jnp.stack(sums.state), passing
        states = lax.cond(accurate, exactly, lambda _: roughly, u)
    rows = rows_at(states, p, form)

    matrix = _matrix(sums, rate)
    ahead = [
        _sum(whole[:, c] * sums.moved[c] for c in range(u.shape[1])) - part
        for whole, part in zip(sums.whole, sums.reached, strict=True)
    ]
    changed = _sum(rate[:, c] * sums.moved[c] for c in range(u.shape[1]))
    reached = jnp.concatenate([ahead[0], changed, *ahead[1:]])
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
