"""Linearised terminal errors of a slew in one pass, without automatic differentiation.

Where the total momentum is small the gyroscopic terms hardly matter: an impulse changes the rate
by as much in body axes for good, and the attitude at the end by the integral of the body-to-
inertial rotation from then on, which is its whole integral less what has passed.  So the sums over
all intervals that a step of least weighted norm asks for can be taken on the way.  The rows are
exact in the end, so a Newton iteration has the right fixed point; it contracts by about |H| T / J
an iteration.  The sums are taken in single precision, which moves that point by some 1e-7 rad.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Iterable
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


def _dot(row: Components, other: Components) -> Array:
    return _sum(x * y for x, y in zip(row, other, strict=True))


def _scaled(columns: Columns, weight: Components) -> Columns:
    return tuple(tuple(x * w for x, w in zip(row, weight, strict=True)) for row in columns)


def _swapped(columns: Columns) -> Columns:
    return tuple(zip(*columns, strict=True))


def _product(a: Columns, b: Columns) -> Columns:
    """Product a b'."""
    return tuple(tuple(_dot(x, y) for y in b) for x in a)


def _combined(operation: Callable[..., Array], *columns: Columns) -> Columns:
    found: Columns = jax.tree.map(operation, *columns)
    return found


def _components(matrix: Array) -> Columns:
    return tuple(tuple(row[c] for c in range(matrix.shape[1])) for row in matrix)


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
    whole: tuple[Columns, ...]
    weight: Components
    moved: Components
    first: tuple[Columns, ...]
    second: tuple[Columns, ...]
    reached: tuple[Components, ...]
    history: Array


def _sweep(
    u: Array, weights: Array, moved: Array, impulse: Array, p: SlewParameters, form: SlewForm
) -> _Sums:
    count, size = u.shape
    targets = 1 + form.has_waypoint
    momentum, columns = tuple(p.momentum[i] for i in range(3)), _components(impulse)

    def integral(q_ib: Components) -> Columns:
        return _product(_rotation(q_ib), _swapped(columns))

    def interval(carry: Any, inputs: Any) -> tuple[Any, Array]:
        state, begin, passed, sums = carry
        control, weight, part, counts, h = inputs
        change = tuple(_dot(row, control) for row in columns)
        state = turn(state, momentum, change, h, p.body.inverse_inertia)
        end = integral(state[:4])
        # Of an interval's impulse the rate has what is left of it: at once none, at its end all.
        lengths = [h, h * counts][:targets]
        before = tuple(
            _combined(lambda s, a, b, x=x: s + x * (a / 3.0 + b / 6.0), until, begin, end)
            for x, until in zip(lengths, passed, strict=True)
        )
        after = tuple(
            _combined(lambda s, a, b, x=x: s + 0.5 * x * (a + b), until, begin, end)
            for x, until in zip(lengths, passed, strict=True)
        )
        weighted = tuple(_scaled(q, weight) for q in before)
        squares = tuple(_product(weighted[a], before[b]) for a, b in _pairs(targets))
        reached = tuple(tuple(_dot(row, part) for row in q) for q in before)
        sums = jax.tree.map(jnp.add, sums, (weight, part, weighted, squares, reached))
        out = [x for q in before for row in q for x in row]
        out += state[:4] if form.has_waypoint else ()
        return (state, end, after, sums), jnp.stack(out)

    zero = jnp.zeros((), u.dtype)
    few, three = (zero,) * size, (zero,) * 3
    start, table = tuple(p.start[i] for i in range(7)), (few,) * 3
    squares = ((three,) * 3,) * len(_pairs(targets))
    sums = (few, few, (table,) * targets, squares, (three,) * targets)
    counts = (jnp.arange(count) < p.waypoint_node).astype(u.dtype)
    # Controls one by one: an array of few columns would have the batch in strides.
    controls = (tuple(x[:, c] for c in range(size)) for x in (u, weights, moved))
    (state, _, whole, sums), history = lax.scan(
        interval,
        (start, integral(start[:4]), (table,) * targets, sums),
        (*controls, counts, jnp.broadcast_to(p.step, (count,))),
    )
    return _Sums(state, whole, *sums, history)


def _in_single(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function of arrays in single precision: twice as many go through a vector unit."""

    def lowered(x: Array) -> Array:
        return x.astype(jnp.float32) if x.dtype == jnp.float64 else x

    found = function(*jax.tree.map(lowered, arguments))
    return jax.tree.map(lambda x: x.astype(jnp.float64), found)


def _pairs(count: int) -> list[tuple[int, int]]:
    return [(a, b) for a in range(count) for b in range(a + 1)]


def _matrix(sums: _Sums, rate: Columns) -> Array:
    """Matrix J diag(weights) J' for the rows: attitude, rate, attitude at the waypoint.

    rate : change of the rate's rows by a unit of each control.
    """
    count = len(sums.whole)
    second = dict(zip(_pairs(count), sums.second, strict=True))
    weighed = [
        _combined(operator.sub, _scaled(whole, sums.weight), first)
        for whole, first in zip(sums.whole, sums.first, strict=True)
    ]

    def block(a: int | None, b: int | None) -> Columns:
        if a is None:
            left = _scaled(rate, sums.weight)
            return _product(left, rate) if b is None else _swapped(block(b, a))
        if b is None:
            return _product(weighed[a], rate)
        if a < b:
            return _swapped(block(b, a))
        crossed = _product(sums.whole[a], sums.first[b])
        found = _combined(operator.sub, _product(weighed[a], sums.whole[b]), crossed)
        return _combined(operator.add, found, second[a, b])

    order = [0, None, *range(1, count)]
    rows = [[x for b in order for x in block(a, b)[i]] for a in order for i in range(3)]
    return jnp.stack([jnp.stack(row) for row in rows])


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
    sums = _in_single(functools.partial(_sweep, form=form), u, weights, moved, impulse, p)
    history, size = sums.history, u.shape[1]

    def pullback(shares: Array) -> Array:
        attitude, turning, *others = (shares[k : k + 3] for k in range(0, len(shares), 3))
        back = _sum(turning[i] * rate[i] for i in range(3))[None]
        for target, share in enumerate([attitude, *others]):
            for i, whole in enumerate(sums.whole[target]):
                first = (3 * target + i) * size
                back = back + share[i] * (jnp.stack(whole)[None] - history[:, first : first + size])
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

    changes = _components(rate)
    matrix = _matrix(sums, changes)
    ahead = [
        [_dot(row, sums.moved) - part for row, part in zip(whole, reached, strict=True)]
        for whole, reached in zip(sums.whole, sums.reached, strict=True)
    ]
    changed = [_dot(row, sums.moved) for row in changes]
    reached = jnp.stack([x for rows_of in (ahead[0], changed, *ahead[1:]) for x in rows_of])
    if p.held.shape[0] == 3:
        return Equations(rows, matrix, reached, pullback)
    # Of the turn at the end, only what moves the boresight.
    slope = swing_slope(inertial_reference(p), states[0][:4], p.held)

    def kept(errors: Array) -> Array:
        turned = _sum(slope[:, k, None] * errors[None, k] for k in range(3))
        return jnp.concatenate([turned, errors[3:]])

    def given(shares: Array) -> Array:
        turn = slope[0] * shares[0] + slope[1] * shares[1]
        return pullback(jnp.concatenate([turn, shares[2:]]))

    return Equations(rows, kept(kept(matrix).T), kept(reached[:, None])[:, 0], given)
