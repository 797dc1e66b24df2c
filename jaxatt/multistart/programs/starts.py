"""Starts of a programme: random controls with their simulated states, and a user's guesses."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.optimal_control import OptimalControlProgram, fly
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import QUICK_TO_COMPILE

_LARGEST = 1e8
"""Size of a state beyond which a flown start is not used."""
_WEAKEST = 0.05
"""Least amplitude of a start's controls."""
_MOST_KNOTS = 8
_OFF = 1e-2
"""Share of a state's range by which a start keeps off its bounds."""
_SPREAD = 4.0
"""Factor by which a start's final time may be longer or shorter where it has no limits."""


class ProgramStarts(NamedTuple):
    """Starting points; leading axis S.

    u : (S, N, b), controls of the stages.  x : (S, N + 1, s), states at all nodes.
    """

    u: Floats
    x: Floats


def _between(share: Floats, lower: Floats, upper: Floats, guess: Floats) -> Floats:
    """A share of the way from lower to upper bounds, or around the guess where one is missing."""
    wide = np.log(_SPREAD)
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper, guess) - 2 * wide)
    high = np.where(
        np.isfinite(upper), upper, np.where(np.isfinite(lower), lower, guess) + 2 * wide
    )
    alone = ~np.isfinite(lower) & ~np.isfinite(upper)
    low, high = np.where(alone, guess - wide, low), np.where(alone, guess + wide, high)
    return low + share * (high - low)


def _inside(states: Floats, lower: Floats, upper: Floats) -> Floats:
    """States (..., s) that keep a little off their bounds."""
    off = np.minimum(_OFF, _OFF * np.where(np.isfinite(upper - lower), upper - lower, 1.0))
    return np.clip(states, lower + off, upper - off)


def _controls(rng: np.random.Generator, lower: Floats, upper: Floats) -> Floats:
    """Controls (N, b) along straight lines between a few random knots, within their limits."""
    count, size = lower.shape
    knots = int(rng.integers(2, min(_MOST_KNOTS, count + 1) + 1))
    heights = rng.uniform(_WEAKEST, 1.0) * rng.uniform(-1.0, 1.0, (knots, size))
    at = np.linspace(0.0, knots - 1.0, count)
    shape = np.stack([np.interp(at, np.arange(knots), heights[:, j]) for j in range(size)], axis=1)
    low, high = np.isfinite(lower), np.isfinite(upper)
    both = low & high
    below, above = np.where(low, lower, 0.0), np.where(high, upper, 0.0)
    ranged = 0.5 * (below + above) + 0.5 * (above - below) * shape
    one_sided = np.where(low, below + np.abs(shape), np.where(high, above - np.abs(shape), shape))
    return np.where(both, ranged, one_sided)


class Guess(NamedTuple):
    """A user's guesses of G starts; None where controls are drawn or states simulated.

    u : (G, N, b), controls of the stages.  states : (G, N + 1, s), the user's own.
    final_time : (G,) [s].
    """

    u: Floats | None = None
    states: Floats | None = None
    final_time: Floats | None = None


@functools.partial(jax.jit, static_argnames=("program",), compiler_options=QUICK_TO_COMPILE)
def _flown(program: OptimalControlProgram, u: Array, first: Array, args: Any) -> Array:
    def one(u: Array, first: Array) -> Array:
        nodes, end = fly(program, u, args, first)
        return jnp.concatenate([nodes, end[None]])

    return jax.vmap(one)(u, first)


@functools.partial(jax.jit, static_argnames=("program",), compiler_options=QUICK_TO_COMPILE)
def _costs(program: OptimalControlProgram, starts: ProgramStarts, args: Any) -> Array:
    def one(u: Array, x: Array) -> Array:
        def at(u: Array, x: Array, stage: Any) -> Array:
            return program.next_and_cost(x, u, stage, args)[1]

        stages = jax.vmap(at)(u, x[:-1], program.stages(args))
        return jnp.sum(stages) + program.final_cost(x[-1], args)

    return jax.vmap(one)(jnp.asarray(starts.u), jnp.asarray(starts.x))


def typical_cost(program: OptimalControlProgram, starts: ProgramStarts, args: Any) -> float:
    """Median size of the objective over the starts where it is finite and not zero; else 1."""
    size = np.abs(np.asarray(_costs(program, starts, args)))
    size = size[np.isfinite(size) & (size > 0.0)]
    return float(np.median(size)) if len(size) else 1.0


def draw_starts(
    program: OptimalControlProgram,
    args: Any,
    count: int,
    seed: int,
    guess: Guess | None = None,
) -> ProgramStarts:
    """Guesses, then random starts, `count` in all; number i depends on seed and i only."""
    layout = program.layout
    lower, upper = limits_along(program, args)
    first = np.asarray(program.start(args))
    decided = program.free_start
    starts, begins = [], []
    for i in range(count):
        rng = np.random.default_rng((seed, i))
        begin = first.copy()
        if decided and layout is not None:
            share = rng.uniform(size=decided)
            # A horizon that is too short cannot be met, one that is too long can be shortened.
            share[-1:] = np.sqrt(share[-1:]) if layout.free_time else share[-1:]
            begin[-decided:] = _between(share, *layout.decided, first[-decided:])
        starts.append(_controls(rng, lower, upper))
        begins.append(begin)
    u, begin = np.array(starts), np.array(begins)
    guess = Guess() if guess is None else guess
    if guess.u is not None:
        u[: len(guess.u)] = guess.u
    if guess.final_time is not None:
        begin[: len(guess.final_time), -1] = np.log(guess.final_time)
    x = np.array(_flown(program, jnp.asarray(u), jnp.asarray(begin), args))
    wild = ~(np.abs(x) <= _LARGEST).all(axis=(1, 2))
    x[wild] = begin[wild][:, None]
    if layout is not None:
        # What is flown need not be feasible, so its states may as well keep their bounds.
        x[:, 1:, : layout.states] = _inside(x[:, 1:, : layout.states], *layout.bounds)
    if guess.states is not None:
        known, _, own = guess.states.shape
        x[:known] = begin[:known, None]
        x[:known, 1:, :own] = guess.states[:, 1:]
    return ProgramStarts(u, x)


@functools.partial(jax.jit, static_argnames=("program",), compiler_options=QUICK_TO_COMPILE)
def _limits(program: OptimalControlProgram, args: Any) -> tuple[Array, Array]:
    def at(stage: Any) -> tuple[Array, Array]:
        lower, upper = program.control_limits(stage, args)
        size = (program.control_size,)
        return jnp.broadcast_to(lower, size), jnp.broadcast_to(upper, size)

    return jax.vmap(at)(program.stages(args))


def limits_along(program: OptimalControlProgram, args: Any) -> tuple[Floats, Floats]:
    """Lower and upper limits of the controls of the stages, (N, b)."""
    lower, upper = _limits(program, args)
    return np.asarray(lower), np.asarray(upper)
