"""Find a finite starting point, and draw further starts around the user's own."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.arrays import namespace, on_host
from jaxatt.optimize.dense.called import AnyFunctions
from jaxatt.optimize.dense.constraints import Box
from jaxatt.optimize.dense.scaling import scale_of

_INSIDE = 1e-2
_PERTURBED = 14
_LARGEST_UNIT = 1e6
_BLOCK = 64
_SIZES = 10.0 ** np.linspace(-4.0, 1.0, _PERTURBED)[:, None]

Floats = npt.NDArray[np.float64]


class Beginning(NamedTuple):
    """Starting point of a solve with its scaling.

    x : (n,), inside the box.  rows : (1 + q,) there, not scaled.  unit : (n,) of x, powers of two,
    so that nothing is rounded.  scale : (1 + q,) of the rows.  finite : () whether it is.
    """

    x: Array
    rows: Array
    unit: Array
    scale: Array
    finite: Array


def _inside(x: Array, box: Box) -> Array:
    """Push a point off its bounds, by the rule of Waechter & Biegler (2006), section 3.6."""
    xp = namespace(x)
    width = box.upper - box.lower
    half = xp.where(xp.isfinite(width), _INSIDE * width, xp.inf)
    low = xp.minimum(_INSIDE * xp.maximum(1.0, abs(box.lower)), half)
    high = xp.minimum(_INSIDE * xp.maximum(1.0, abs(box.upper)), half)
    lower = xp.where(xp.isfinite(box.lower), box.lower + low, -xp.inf)
    upper = xp.where(xp.isfinite(box.upper), box.upper - high, xp.inf)
    return xp.clip(x, xp.minimum(lower, upper), xp.maximum(lower, upper))


class Draws(NamedTuple):
    """Candidates for one start.

    x0 : (n,), start.  near : (k, n), points around it for where it is not finite.
    """

    x0: Array
    near: Array


def begin(functions: AnyFunctions, draws: Draws, args: Any, box: Box) -> Beginning:
    """The first candidate where all values and derivatives are finite.

    x0 inside the box, x0 pushed off the bounds, x0 perturbed more and more.
    """
    xp = namespace(draws.x0)
    x, rows, derivatives, finite = _first_finite(functions, draws, args, box)
    size = xp.where(finite, xp.clip(abs(x), 1.0, _LARGEST_UNIT), 1.0)
    unit = 2.0 ** xp.floor(xp.log2(size))
    return Beginning(x, rows, unit, scale_of(derivatives * unit[None, :]), finite)


def _first_finite(
    functions: AnyFunctions, draws: Draws, args: Any, box: Box
) -> tuple[Array, Array, Array, Array]:
    """The first finite candidate or the first of all, rows and derivatives, whether it is finite.

    The host evaluates no more candidates than it takes.
    """
    xp, own = namespace(draws.x0), box.project(draws.x0)

    def finite(x: Array) -> tuple[Array, Array, Array, Array]:
        rows, derivatives = functions.derivatives(x, args)
        good = xp.all(xp.isfinite(x)) & xp.all(xp.isfinite(rows))
        return x, rows, derivatives, good & xp.all(xp.isfinite(derivatives))

    def others() -> Array:
        return xp.concatenate([_inside(draws.x0, box)[None], draws.near])

    if on_host(own):
        found = finite(own)
        if found[3]:
            return found
        tried = (finite(x) for x in others())
        return next((other for other in tried if other[3]), found)
    every = jax.vmap(finite)(xp.concatenate([own[None], others()]))
    first = xp.argmax(every[3])
    x, rows, derivatives, good = (leaf[first] for leaf in every)
    return x, rows, derivatives, good


@np.errstate(invalid="ignore")
def draw(own: Floats, index: npt.NDArray[np.int64], box: Box, seed: tuple[int, ...]) -> Draws:
    """Starts `index`, (S,): the user's own (k, n) first, drawn ones beyond.

    Drawn on the host, because JAX's random numbers take seconds to compile.
    """
    count, n = own.shape
    x0, near = np.empty((len(index), n)), np.empty((len(index), _PERTURBED, n))
    for block in range(int(index.min()) // _BLOCK, int(index.max()) // _BLOCK + 1):
        normal, even, coin = _noise(seed, block, n)
        here = (index // _BLOCK == block).nonzero()[0]
        rows = index[here] % _BLOCK
        start, noise = own[index[here] % count], normal[rows]
        mine = (index[here] < count)[:, None]
        if not mine.all():
            drawn = _drawn(start, box, noise[:, 0], even[rows], coin[rows] < 0.5)
            start = np.where(mine, start, drawn)
        x0[here] = start
        start = start[:, None, :]
        around: Any = start + _SIZES * np.maximum(1.0, np.abs(start)) * noise[:, 1:]
        near[here] = _inside(around, box)
    return Draws(x0, near)  # type: ignore[arg-type]


@functools.lru_cache(16)
def _noise(seed: tuple[int, ...], block: int, n: int) -> tuple[Floats, Floats, Floats]:
    """What the starts of a block are drawn from: normal, uniform, uniform."""
    rng = np.random.default_rng([*seed, block])
    normal = rng.normal(size=(_BLOCK, 1 + _PERTURBED, n))
    return normal, rng.uniform(size=(_BLOCK, n)), rng.uniform(size=(_BLOCK, 1))


def _drawn(
    base: Floats, box: Box, normal: Floats, even: Floats, wide: npt.NDArray[np.bool_]
) -> Floats:
    """Draw starts around base, (k, n).

    Normal with the standard deviation max(1, |x0|); where both bounds are finite, every second
    one (wide) uniform over the box instead.
    """
    bounded = np.isfinite(box.lower) & np.isfinite(box.upper)
    lower, upper = np.where(bounded, box.lower, 0.0), np.where(bounded, box.upper, 0.0)
    near = base + np.maximum(1.0, np.abs(base)) * normal
    return np.clip(np.where(wide & bounded, lower + (upper - lower) * even, near), *box)
