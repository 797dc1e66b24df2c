"""Whether a function calls LAPACK when it runs on a CPU.

Programs that do cannot run side by side in several threads, where they may wait for ever for each
other's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import jax

_ROUTINES = (
    *("cholesky", "eig", "eigh", "geqrf", "hessenberg", "householder_product", "lu", "qr", "schur"),
    *("svd", "triangular_solve", "tridiagonal", "tridiagonal_solve"),
)


def calls_lapack(function: Callable[..., Any], *args: Any) -> bool:
    """Whether something in `function`, of arguments like these, is a decomposition or solve."""
    return any(name in _ROUTINES for name in _primitives(jax.make_jaxpr(function)(*args).jaxpr))


def _primitives(jaxpr: Any) -> Iterator[str]:
    """Names of all primitives, those of inner functions and loops included."""
    for equation in jaxpr.eqns:
        yield equation.primitive.name
        for inner in jax.tree.leaves(
            list(equation.params.values()), is_leaf=lambda leaf: hasattr(leaf, "eqns")
        ):
            inner = getattr(inner, "jaxpr", inner)
            if hasattr(inner, "eqns"):
                yield from _primitives(inner)
