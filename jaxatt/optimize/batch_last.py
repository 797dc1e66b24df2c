"""Evaluate functions with the batch axis last, wherever `jax.vmap` has it outside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array
from jax.custom_batching import custom_vmap


def batch_last(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function so that `jax.vmap` puts the batch axis last inside it.

    There every component is one contiguous vector, which small systems and roll-outs gain much
    from, while products of large matrices around them want the axis first.
    """

    def call(*args: Any) -> Any:
        leaves, tree = jax.tree.flatten(args)

        def flat(*leaves: Array) -> Any:
            return function(*jax.tree.unflatten(tree, leaves))

        batched = custom_vmap(flat)

        @batched.def_vmap
        def _(size: int, moved: list[bool], *leaves: Array) -> Any:
            last = [jnp.moveaxis(x, 0, -1) if m else x for x, m in zip(leaves, moved, strict=True)]
            axes = [-1 if m else None for m in moved]
            found = jax.vmap(flat, in_axes=axes, out_axes=-1)(*last)
            first = jax.tree.map(lambda x: jnp.moveaxis(x, -1, 0), found)
            return first, jax.tree.map(lambda _: True, first)

        return batched(*leaves)

    return call
