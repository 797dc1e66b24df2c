"""Whether a retraction and a difference of states define one manifold."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

_SMALL = 1e-3
_AGREES = 1e-6
"""Difference between an error and what becomes of it by retract and difference."""


def check_manifold(
    retract: Callable[[Array, Array], Array],
    difference: Callable[[Array, Array], Array],
    x: Array,
    size: int,
) -> None:
    """Raise ValueError unless retract(x, 0) = x and difference(retract(x, e), x) = e.

    x : (s,), a state.  size : of its error; e is a few small ones.
    """
    moved = jax.eval_shape(retract, x, jnp.zeros(size)).shape
    if moved != x.shape:
        raise ValueError(f"retract returns an array of shape {moved}; {x.shape} is expected")
    missed = jax.eval_shape(difference, x, x).shape
    if missed != (size,):
        raise ValueError(
            f"difference returns an array of shape {missed}; ({size},), error_size, is expected"
        )
    rng = np.random.default_rng(0)
    for error in (np.zeros(size), *(_SMALL * rng.normal(size=(3, size)))):
        back = np.asarray(difference(retract(x, jnp.asarray(error)), x))
        if not np.abs(back - error).max() <= _AGREES:
            raise ValueError(
                f"retract and difference disagree at x = {np.asarray(x)}: "
                f"difference(retract(x, e), x) is {back} for e = {error}, and e is expected"
            )
    same = np.asarray(retract(x, jnp.zeros(size)))
    if not np.abs(same - np.asarray(x)).max() <= _AGREES:
        raise ValueError(f"retract(x, 0) is {same} at x = {np.asarray(x)}; x is expected")
