"""Linearised rows in the form that weighted least-norm steps need."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

Response = Callable[[Array], tuple[Array, Array]]
"""u (N, b) -> rows (m,) and their derivatives (N, m, b)."""


class Equations(NamedTuple):
    """Rows r and products with their Jacobian J, which need not be formed.

    rows : (m,).  matrix : (m, m), J diag(weights) J'.  reached : (m,), J moved.
    pullback : (m,) -> (N, b), the product of J' with it.
    """

    rows: Array
    matrix: Array
    reached: Array
    pullback: Callable[[Array], Array]


Linearise = Callable[[Array, Array, Array, Array], Equations]
"""(u, weights, moved, whether the rows must be exact) -> equations."""


def from_response(response: Response) -> Linearise:
    """Linearised rows from a function that returns their derivatives."""

    def linearise(u: Array, weights: Array, moved: Array, accurate: Array) -> Equations:
        rows, jacobian = response(u)
        return Equations(
            rows,
            jnp.einsum("kic,kjc->ij", jacobian * weights[:, None], jacobian),
            jnp.einsum("kic,kc->i", jacobian, moved),
            lambda shares: jnp.einsum("kic,i->kc", jacobian, shares),
        )

    return linearise
