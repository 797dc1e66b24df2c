"""When an orbit enters and leaves the Earth's shadow."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.environment import epoch
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.light import Light, to_sun
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_BLOCK = 1024  # instants of one evaluation
_ROOTS = 32  # crossings of one bisection
_HALVINGS = 40


@dataclass(frozen=True)
class Eclipse:
    """One passage through the shadow, in times [s] after the epoch; nan for an event outside the
    interval that was looked at, or for an umbra that is not met."""

    penumbra_entry: float
    umbra_entry: float
    umbra_exit: float
    penumbra_exit: float


def eclipses(
    task: OrbitTask, light: Light, start: float, stop: float, spacing: float = 5.0
) -> tuple[Eclipse, ...]:
    """Return the passages through the shadow between two times [s] after the epoch, in order.

    spacing : [s], of the instants between which edges of the shadow are looked for; a passage that
    is shorter may be missed.  The times are exact to spacing / 2^40.
    """
    if light.shadow is None:
        return ()
    count = max(2, math.ceil((stop - start) / spacing) + 1)
    times = np.linspace(start, stop, count)
    inside = _sampled(task, light, times)
    penumbras, umbras = (
        _pairs(_edges(task, light, times, inside[:, row], row), bool(inside[0, row] > 0.0))
        for row in range(2)
    )
    return tuple(_passage(first, last, umbras) for first, last in penumbras)


def _depths(task: OrbitTask, light: Light, times: Array) -> Array:
    """Angles (n, 2) [rad] into penumbra and umbra, positive inside."""
    assert light.shadow is not None
    r_i = task.motion.at(times).position
    days = task.days + times / epoch.SECONDS_PER_DAY
    seen = light.shadow.disks(r_i, to_sun(light, r_i, days))
    return jnp.stack([seen.into_penumbra, seen.into_umbra], axis=-1)


_evaluated = jax.jit(_depths, compiler_options=RUNS_ONCE)


@functools.partial(jax.jit, compiler_options=RUNS_ONCE)
def _bisected(task: OrbitTask, light: Light, low: Array, high: Array, row: Array) -> Array:
    """Times (m,) [s] at which a depth changes sign, between low and high (m,)."""

    def halve(_: int, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        same = (_depths(task, light, middle)[:, row] > 0.0) == began
        return jnp.where(same, middle, low), jnp.where(same, high, middle)

    began = _depths(task, light, low)[:, row] > 0.0
    low, high = lax.fori_loop(0, _HALVINGS, halve, (low, high))
    return 0.5 * (low + high)


def _sampled(task: OrbitTask, light: Light, times: Floats) -> Floats:
    padded = np.pad(times, (0, -len(times) % _BLOCK), mode="edge")
    blocks = [np.asarray(_evaluated(task, light, part)) for part in padded.reshape(-1, _BLOCK)]
    return np.concatenate(blocks)[: len(times)]


def _edges(task: OrbitTask, light: Light, times: Floats, depth: Floats, row: int) -> Floats:
    """Times (k,) [s] at which the depth passes through zero."""
    before = np.flatnonzero((depth[1:] > 0.0) != (depth[:-1] > 0.0))
    found = np.zeros(0)
    for first in range(0, len(before), _ROOTS):
        chosen = before[first : first + _ROOTS]
        filled = np.pad(chosen, (0, _ROOTS - len(chosen)), mode="edge")
        roots = _bisected(task, light, times[filled], times[filled + 1], jnp.asarray(row))
        found = np.concatenate([found, np.asarray(roots)[: len(chosen)]])
    return found


def _pairs(edges: Floats, inside: bool) -> list[tuple[float, float]]:
    """Entries and exits of the passages; nan for those outside the interval."""
    ends = ([math.nan] if inside else []) + edges.tolist()
    ends += [math.nan] * (len(ends) % 2)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _passage(first: float, last: float, umbras: list[tuple[float, float]]) -> Eclipse:
    """The passage from `first` to `last` with the umbra that it meets."""
    # A comparison with nan, a time outside the interval, is never true.
    met = (umbra for umbra in umbras if not (umbra[1] < first or umbra[0] > last))
    entry, left = next(met, (math.nan, math.nan))
    return Eclipse(first, entry, left, last)
