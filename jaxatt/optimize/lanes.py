"""Evaluate functions with all batch axes as one, the last axis of their arrays: lanes.

Derivatives of an interval are many short rows, and `jax.vmap` puts its axes before them inside
every loop, where a CPU then works on pieces of a few numbers.  With the lanes last the pieces are
as long as there are stages and starts together, which is several times faster.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax
from jax.custom_batching import custom_vmap


def in_lanes(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function of arrays that all have one more axis behind their own, of lanes.

    However many `jax.vmap` there are around it, the function is called once, with their axes as
    that one; without any it has length 1.  What is the same for all lanes may have length 1, among
    arguments and results alike.
    """

    def call(*args: Any) -> Any:
        leaves, tree = jax.tree.flatten(args)

        def flat(*leaves: Array) -> Any:
            return function(*jax.tree.unflatten(tree, leaves))

        found = _batched(flat)(*(jnp.asarray(leaf)[..., None] for leaf in leaves))
        return jax.tree.map(lambda leaf: leaf[..., 0], found)

    return call


def _batched(flat: Callable[..., Any]) -> Callable[..., Any]:
    """Function of arrays with a last axis of lanes, to which every `jax.vmap` adds its own."""
    batched = custom_vmap(flat)

    @batched.def_vmap
    def _(size: int, moved: list[bool], *leaves: Array) -> Any:
        before = max(leaf.shape[-1] for leaf in leaves)

        def joined(leaf: Array, along: bool) -> Array:
            if not along and leaf.shape[-1] == 1:
                return leaf
            leaf = jnp.moveaxis(leaf, 0, -1) if along else leaf[..., None]
            own = leaf.shape[:-2]
            return jnp.broadcast_to(leaf, (*own, before, size)).reshape(*own, before * size)

        def parted(leaf: Array) -> Array:
            own = leaf.shape[:-1]
            every = jnp.broadcast_to(leaf, (*own, before * size))
            return jnp.moveaxis(every.reshape(*own, before, size), -1, 0)

        wide = [joined(leaf, along) for leaf, along in zip(leaves, moved, strict=True)]
        found = jax.tree.map(parted, _batched(flat)(*wide))
        return found, jax.tree.map(lambda _: True, found)

    return batched


def each_lane(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function of arrays, so that it takes arrays with lanes behind their own axes.

    For functions that are written for one lane, within those of `in_lanes`.
    """

    def call(*args: Any) -> Any:
        leaves, tree = jax.tree.flatten(args)
        lanes = max(leaf.shape[-1] for leaf in leaves)
        axes = [-1 if leaf.shape[-1] == lanes else None for leaf in leaves]
        own = [leaf if axis else leaf[..., 0] for leaf, axis in zip(leaves, axes, strict=True)]

        def one(*leaves: Array) -> Any:
            return function(*jax.tree.unflatten(tree, leaves))

        return jax.vmap(one, in_axes=axes, out_axes=-1)(*own)

    return call


def computed_once(function: Callable[..., Any], always: Array) -> Callable[..., Any]:
    """Wrap a function, within a loop, so that XLA computes its results once.

    It would put what leads to them into every operation that uses them, and compute it for each of
    their entries.  It takes a branch for what it is: always : (), a condition that always holds
    but that only the loop knows, e.g. that its index is not negative.
    """

    traced = jax.jit(function, inline=True)  # once, for both uses of it here

    def nothing(*args: Any) -> Any:
        shapes = jax.eval_shape(traced, *args)
        return jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes)

    def call(*args: Any) -> Any:
        return lax.cond(always, traced, nothing, *args)

    return call
