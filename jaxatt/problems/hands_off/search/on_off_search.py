"""Combinatorial search for thrusters that are open for whole intervals.

Every pattern is flown, many at once; single openings are flipped or moved for as long as that
brings the end nearer, from randomly rounded beginnings and then, again and again, from the best
with a few openings changed (iterated local search).
"""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.slew.thruster_response import thruster_rows
from jaxatt.problems.terminal_rows import RATE_SCALE
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import CHUNK, in_chunks

Bits = npt.NDArray[np.bool_]

_BEGINNINGS = 64
_DESCENTS = 4
_KICKS = 40
_KICKED = 4
_ROUNDS = 40


@functools.partial(jax.jit, static_argnames=("form",))
def _ends(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Terminal errors (S, 6) of scaled controls (S, N, b)."""
    last = jnp.moveaxis(u, 0, -1)
    return jax.vmap(lambda one: thruster_rows(one, p, form), in_axes=-1)(last)


def nearest_pattern(task: SlewTask, u: Floats, sign: float, seed: int) -> Floats:
    """Controls (N, b) with thrusters at 0 or 1 whose flight ends nearest to the target.

    u : (N, b), a relaxed answer; the result has no more active intervals.  sign : the way round.
    Nearest means the largest error in units of its tolerance.  Wheels keep their torque.
    """
    p = task.system.turned(task.arguments.plant, jnp.asarray(sign))
    first = task.craft.wheels.count
    allowed = np.asarray(task.arguments.free)[:, first:] > 0
    most = int((u[:, first:] > 0.0).any(axis=1).sum())
    pairs = task.craft.thrusters.opposed
    scale = np.array(
        [1.0 / task.tolerances["attitude"], 1.0 / (RATE_SCALE * task.tolerances["rate"])]
    )

    def score(bits: Bits) -> Floats:
        full = np.concatenate(
            [np.broadcast_to(u[:, :first], (*bits.shape[:2], first)), bits.astype(float)], axis=-1
        )
        rows = in_chunks(
            lambda chunk: _ends(chunk, p, task.form),
            full,
            4 * CHUNK,
            key=("on-off", task.form, full.shape[1:]),
        )
        parts = np.stack([np.linalg.norm(rows[:, :3], axis=1), np.linalg.norm(rows[:, 3:], axis=1)])
        return np.asarray((parts * scale[:, None]).max(axis=0))

    def admissible(bits: Bits) -> Bits:
        ok = bits.any(axis=2).sum(axis=1) <= most
        ok &= ~(bits & ~allowed).any(axis=(1, 2))
        for i, j in pairs:
            ok &= ~(bits[:, :, i] & bits[:, :, j]).any(axis=1)
        return np.asarray(ok)

    rng = np.random.default_rng(seed)
    share = u[:, first:]
    drawn = rng.uniform(size=(_BEGINNINGS, *share.shape)) < share[None]
    begun = np.concatenate([(share > 0.5)[None], drawn])
    begun = begun[admissible(begun)]
    if not len(begun):
        begun = np.zeros((1, *share.shape), bool)
    order = np.argsort(score(begun))[:_DESCENTS]
    ends = [_descend(begun[i], score, admissible) for i in order]
    best, value = min(ends, key=lambda end: end[1])
    for _ in range(_KICKS):
        kicked = _kicked(best, rng)
        if not admissible(kicked[None])[0]:
            continue
        other, reached = _descend(kicked, score, admissible)
        if reached < value:
            best, value = other, reached
    return np.concatenate([u[:, :first], best.astype(float)], axis=1)


def _descend(bits: Bits, score: object, admissible: object) -> tuple[Bits, float]:
    """End of a steepest descent over patterns, and its score."""
    assert callable(score) and callable(admissible)
    value = float(score(bits[None])[0])
    for _ in range(_ROUNDS):
        near = _neighbours(bits)
        near = near[admissible(near)]
        values = score(near)
        index = int(values.argmin())
        if not values[index] < value:
            break
        bits, value = near[index], float(values[index])
    return bits, value


def _kicked(bits: Bits, rng: np.random.Generator) -> Bits:
    """Pattern with a few random openings of its used intervals flipped."""
    used = np.flatnonzero(bits.any(axis=1))
    if not len(used):
        return bits
    changed = bits.copy()
    rows = rng.choice(used, _KICKED)
    columns = rng.integers(bits.shape[1], size=_KICKED)
    changed[rows, columns] = ~changed[rows, columns]
    return changed


def _neighbours(bits: Bits) -> Bits:
    """Patterns (S, N, m) with one opening flipped, or moved to a nearby interval."""
    made = []
    used = np.flatnonzero(bits.any(axis=1))
    beside = np.unique(np.clip(np.concatenate([used - 1, used, used + 1]), 0, len(bits) - 1))
    for k in used:
        for j in range(bits.shape[1]):
            flipped = bits.copy()
            flipped[k, j] = not bits[k, j]
            made.append(flipped)
    for k, j in np.argwhere(bits):
        for place in beside[~bits[beside, j]]:
            moved = bits.copy()
            moved[k, j], moved[place, j] = False, True
            made.append(moved)
    return np.stack(made) if made else bits[None]
