"""Starts of a manoeuvre by magnetorquers alone: the sun attitude held, or a straight turn.

A start is a path of attitudes to the sun attitude, with any roll about the line to the sun, along
it, and on to the target, or straight to the target; flown by a magnetic feedback law, which follows
it as well as the field allows.  Final times are short ones, ones just before the satellite enters
the shadow, and ones after it.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.environment.eclipse_times import eclipses
from jaxatt.problems.net_power.magnetic.follow import follow
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.paths import blend
from jaxatt.problems.net_power.magnetic.program import wanted
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.runtime.arrays import Flags, Floats

_SHORT, _LONG = (2.0, 8.0), (6.0, 20.0)
"""Straight turns, and visits to the sun attitude, in units of time of the task."""
_SLEW = (2.0, 7.0)
"""Turns to the sun attitude and away from it."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Starts:
    """Starts of one task, leading axis S.

    u : (S, N, 3) and x : (S, N + 1, 8), of the programme.
    reference : (S, 4), target attitude, its sign by the way round.  time_weight : (S,).
    """

    u: Array | Floats
    x: Array | Floats
    reference: Array | Floats
    time_weight: Array | Floats

    def pick(self, rows: Any) -> Starts:
        """Some of the starts."""
        chosen: Starts = jax.tree.map(lambda leaf: np.asarray(leaf)[rows], self)
        return chosen

    @property
    def final_time(self) -> Floats:
        """Final times (S,) [s]."""
        return np.exp(np.asarray(self.x)[:, -1, -1])


def make_starts(task: MagneticTask, count: int, seed: int) -> Starts:
    """Make `count` starts."""
    rng = np.random.default_rng(seed)
    m = task.manoeuvre
    straight = np.arange(count) % 4 == 3
    final = np.clip(_final_times(task, rng, straight), 1.02 * m.shortest, 0.98 * m.longest)
    near = rng.normal(size=(count, 4))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    begin = np.asarray(task.parameters.start)[:4]
    near = np.where(rng.integers(3, size=(count, 1)) == 0, begin, near)
    middle = task.sun_attitudes(near, 0.5 * float(np.median(final)))
    visits = (None if s else q for s, q in zip(straight, middle, strict=True))
    paths = np.stack([_path(task, rng, t, q) for t, q in zip(final, visits, strict=True)])
    u, x = (np.asarray(found) for found in follow(task, paths, final))
    return Starts(u, x, nearer(task, x), np.full(count, float(m.time_weight)))


def nearer(task: MagneticTask, x: Floats) -> Floats:
    """Target attitude (S, 4) with the sign nearer to the end of states (S, N + 1, 8)."""
    reference = np.asarray(task.parameters.reference)
    ends = jnp.asarray(x[:, -1])
    target = np.asarray(_targets(task.form(True), task.parameters, ends))
    alike = np.sum(target * x[:, -1, :4], axis=1)
    return np.where(alike < 0.0, -1.0, 1.0)[:, None] * reference


@functools.partial(jax.jit, static_argnums=0)
def _targets(form: MagneticForm, p: MagneticParameters, ends: Array) -> Array:
    return jax.vmap(lambda x: wanted(x, p, form)[0])(ends)


def _final_times(task: MagneticTask, rng: np.random.Generator, straight: Flags) -> Floats:
    """Final times (S,) [s]."""
    m, count = task.manoeuvre, len(straight)
    short = np.exp(rng.uniform(math.log(_SHORT[0]), math.log(_SHORT[1]), count)) * task.unit
    long = np.exp(rng.uniform(math.log(_LONG[0]), math.log(_LONG[1]), count)) * task.unit
    final = np.where(straight, short, long)
    assert m.satellite.orbit is not None
    shadow = eclipses(m.satellite.orbit, m.satellite.light, m.start_time, m.start_time + m.longest)
    turn = np.arange(count)
    for passage in shadow[:1]:
        entry, leave = passage.penumbra_entry - m.start_time, passage.penumbra_exit - m.start_time
        if entry > m.shortest:
            final = np.where(turn % 8 == 2, rng.uniform(0.75, 1.0, count) * entry, final)
        if leave < m.longest:
            late = leave + rng.uniform(0.05, 1.0, count) * (m.longest - leave)
            final = np.where(turn % 16 == 6, late, final)
    if m.cost == "energy" or not shadow:
        final = np.where(turn % 8 == 4, rng.uniform(0.5, 1.0, count) * m.longest, final)
    return final


def _path(
    task: MagneticTask, rng: np.random.Generator, final: float, middle: Floats | None
) -> Floats:
    """Attitudes (N + 2, 4) at the nodes, and one beyond, of one start.

    middle : (4,), held on the way; None for a straight turn.
    """
    m = task.manoeuvre
    times = final / m.intervals * np.arange(m.intervals + 2, dtype=np.float64)
    begin, end = np.asarray(task.parameters.start)[:4], task.target_at(final).q_ib
    if middle is None:
        return blend(begin, end, times / final)
    there, back = np.minimum(rng.uniform(*_SLEW, 2) * task.unit, 0.45 * final)
    first = blend(begin, middle, times / there)
    last = blend(middle, end, (times - (final - back)) / back)
    return np.where((times < 0.5 * (there + final - back))[:, None], first, last)
