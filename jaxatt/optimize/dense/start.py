"""Find a finite starting point, and draw further starts around the user's own."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense.functions import Functions, scale_of
from jaxatt.optimize.dense.residuals import Box

_INSIDE = 1e-2
_PERTURBED = 14
_LARGEST_UNIT = 1e6


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
    width = box.upper - box.lower
    half = jnp.where(jnp.isfinite(width), _INSIDE * width, jnp.inf)
    low = jnp.minimum(_INSIDE * jnp.maximum(1.0, jnp.abs(box.lower)), half)
    high = jnp.minimum(_INSIDE * jnp.maximum(1.0, jnp.abs(box.upper)), half)
    lower = jnp.where(jnp.isfinite(box.lower), box.lower + low, -jnp.inf)
    upper = jnp.where(jnp.isfinite(box.upper), box.upper - high, jnp.inf)
    return jnp.clip(x, jnp.minimum(lower, upper), jnp.maximum(lower, upper))


class Draws(NamedTuple):
    """Candidates for one start.

    x0 : (n,), start.  near : (k, n), points around it for where it is not finite.
    """

    x0: Array
    near: Array


def begin(functions: Functions, draws: Draws, args: Any, box: Box) -> Beginning:
    """The first candidate where all values and derivatives are finite.

    x0 inside the box, x0 pushed off the bounds, x0 perturbed more and more.
    """
    candidates = jnp.concatenate(
        [box.project(draws.x0)[None], _inside(draws.x0, box)[None], draws.near]
    )
    values, derivatives = jax.vmap(lambda x: functions.derivatives(x, args))(candidates)
    finite = jnp.all(jnp.isfinite(values), axis=1) & jnp.all(jnp.isfinite(derivatives), axis=(1, 2))
    finite = finite & jnp.all(jnp.isfinite(candidates), axis=1)
    first = jnp.argmax(finite)
    x = candidates[first]
    size = jnp.where(finite[first], jnp.clip(jnp.abs(x), 1.0, _LARGEST_UNIT), 1.0)
    unit = 2.0 ** jnp.floor(jnp.log2(size))
    scale = scale_of(derivatives[first] * unit[None, :])
    return Beginning(x, values[first], unit, scale, finite[first])


@jax.jit
def draw(own: Array, index: Array, box: Box, root: Array) -> Draws:
    """Starts `index`, (S,): the user's own (k, n) first, drawn ones beyond.

    Compiled apart from the solver, which depends on the functions: random numbers take long.
    """
    count, n = own.shape

    def one(i: Array) -> Draws:
        key, other = jax.random.split(jax.random.fold_in(root, i))
        base = own[i % count]
        x0 = jnp.where(i < count, base, drawn(base, box, key))
        noise = jax.random.normal(other, (_PERTURBED, n), x0.dtype)
        size = 10.0 ** jnp.linspace(-4.0, 1.0, _PERTURBED, dtype=x0.dtype)
        moved = x0[None, :] + size[:, None] * jnp.maximum(1.0, jnp.abs(x0))[None, :] * noise
        return Draws(x0, jax.vmap(lambda x: _inside(x, box))(moved))

    return jax.vmap(one)(index)


def drawn(x0: Array, box: Box, key: Array) -> Array:
    """Draw a start around x0, (n,).

    Normal with the standard deviation max(1, |x0|); where both bounds are finite, every second
    one uniform over the box instead.
    """
    shape, dtype = x0.shape, x0.dtype
    one, two, three = jax.random.split(key, 3)
    spread = jnp.maximum(1.0, jnp.abs(x0))
    near = x0 + spread * jax.random.normal(one, shape, dtype)
    bounded = jnp.isfinite(box.lower) & jnp.isfinite(box.upper)
    lower, upper = jnp.where(bounded, box.lower, 0.0), jnp.where(bounded, box.upper, 0.0)
    anywhere = lower + (upper - lower) * jax.random.uniform(two, shape, dtype)
    wide = bounded & jax.random.bernoulli(three)
    return box.project(jnp.where(wide, anywhere, near))
