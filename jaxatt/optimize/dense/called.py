"""The functions of a small programme, compiled one by one and called from the host."""

from __future__ import annotations

import functools
from typing import Any

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.runtime.compilation import Routine

Floats = npt.NDArray[np.float64]


@functools.partial(Routine, statics=1, kept=False)
def _derivatives(functions: Functions, x: Array, args: Any) -> Array:
    """Stacked rows in the first column, (1 + q, 1 + n): one result is handed over faster."""
    rows, derivatives = functions.derivatives(x, args)
    return jnp.concatenate([rows[:, None], derivatives], axis=1)


@functools.partial(Routine, statics=1, kept=False)
def _hessian(functions: Functions, x: Array, args: Any, weights: Array) -> Array:
    return functions.hessian(x, args, weights)


@functools.partial(Routine, statics=1, kept=False)
def _many(functions: Functions, points: Array, args: Any) -> Array:
    return functions.many(points, args)


class CalledFunctions:
    """As `Functions`, for NumPy arrays."""

    def __init__(self, functions: Functions, equalities: int, inequalities: int) -> None:
        self._functions, self._counts = functions, (equalities, inequalities)

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support."""
        return self._functions.features

    def counts(self, x: Any, args: Any) -> tuple[int, int]:
        """Number of equalities and inequalities."""
        return self._counts

    def derivatives(self, x: Any, args: Any) -> tuple[Any, Any]:
        """Stacked rows (1 + q,) and their derivatives (1 + q, n)."""
        found: Floats = np.asarray(_derivatives(self._functions, x, args))
        return found[:, 0], found[:, 1:]

    def hessian(self, x: Any, args: Any, weights: Any) -> Any:
        """Second derivatives (n, n) of the sum of rows with weights (1 + q,)."""
        return np.asarray(_hessian(self._functions, x, args, weights))

    def many(self, points: Any, args: Any) -> Any:
        """Stacked rows (k, 1 + q) at points (k, n)."""
        return np.asarray(_many(self._functions, points, args))


AnyFunctions = Functions | CalledFunctions
"""A programme of the dense solver, for JAX's arrays or for NumPy's."""
