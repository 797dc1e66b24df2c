"""The functions of a small programme, compiled one by one and called from the host."""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.proposals import BATCH
from jaxatt.runtime.settings import QUICK_TO_COMPILE

Floats = npt.NDArray[np.float64]

_MOST_SECOND = 1000
"""Second derivatives of all rows that are asked for together; of more rows, a weighted sum is."""
REMEMBERED = 256
"""Problems of which anything is kept, those that were met last: each holds the user's functions."""


class _Compiled:
    """The functions of a programme as they are compiled; one result is handed over faster."""

    def __init__(self, functions: Functions) -> None:
        def derivatives(x: Array, args: Any) -> Array:
            """Stacked rows in the first column, (1 + q, 1 + n)."""
            rows, first = functions.derivatives(x, args)
            return jnp.concatenate([rows[:, None], first], axis=1)

        def second_derivatives(x: Array, args: Any) -> Array:
            """Also with the second derivatives, (1 + q, 1 + n + n^2)."""
            rows, first, second = functions.second_derivatives(x, args)
            return jnp.concatenate(
                [rows[:, None], first, second.reshape(rows.shape[0], -1)], axis=1
            )

        def merits(points: Array, args: Any, packed: Array) -> Array:
            """As `Functions.merits`; every array that is handed over takes time."""
            scale, weight, penalty = packed[0], packed[1, 0], packed[2, 1:]
            merit = Merit(weight, packed[1, 1:], penalty, packed[3, 1:])
            return functions.merits(points, args, scale, merit)

        self.derivatives = jax.jit(derivatives, compiler_options=QUICK_TO_COMPILE)
        self.second = jax.jit(second_derivatives, compiler_options=QUICK_TO_COMPILE)
        self.hessian = jax.jit(functions.hessian, compiler_options=QUICK_TO_COMPILE)
        self.merits = jax.jit(merits, compiler_options=QUICK_TO_COMPILE)


_compiled = functools.lru_cache(REMEMBERED)(_Compiled)


class CalledFunctions:
    """As `Functions`, for NumPy arrays and one set of arguments.

    Of few rows and variables all second derivatives come with the first ones, in one call.  What
    was asked last is remembered.
    """

    def __init__(self, functions: Functions, equalities: int, inequalities: int) -> None:
        self._functions, self._counts = functions, (equalities, inequalities)
        self._compiled = _compiled(functions)
        self._known: dict[bytes, Floats] = {}

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support."""
        return self._functions.features

    def counts(self, x: Any, args: Any) -> tuple[int, int]:
        """Number of equalities and inequalities."""
        return self._counts

    def derivatives(self, x: Any, args: Any) -> tuple[Any, Any]:
        """Stacked rows (1 + q,) and their derivatives (1 + q, n)."""
        found = self._at(x, args)
        return found[:, 0], found[:, 1 : 1 + len(x)]

    def hessian(self, x: Any, args: Any, weights: Any) -> Any:
        """Second derivatives (n, n) of the sum of rows with weights (1 + q,)."""
        n = len(x)
        if len(weights) * n * n > _MOST_SECOND:
            return np.asarray(self._compiled.hessian(x, args, weights))
        return weights.dot(self._at(x, args)[:, 1 + n :]).reshape(n, n)

    def merits(self, points: Any, args: Any, scale: Any, merit: Merit) -> Any:
        """Merit (k,) of the rows times `scale`, (1 + q,), at points (k, n)."""
        packed = np.empty((4, len(scale)))
        packed[0], packed[1, 0], packed[1, 1:] = scale, merit.weight, merit.multipliers
        packed[2], packed[3] = 0.0, 0.0
        packed[2, 1:], packed[3, 1:] = merit.penalty, merit.most
        found = []
        for some in range(0, len(points), BATCH):
            batch = points[some : some + BATCH]
            if len(batch) < BATCH:  # one shape is compiled once
                batch = np.concatenate([batch, np.repeat(batch[:1], BATCH - len(batch), axis=0)])
            found.append(np.asarray(self._compiled.merits(batch, args, packed)))
        return found[0] if len(found) == 1 else np.concatenate(found)[: len(points)]

    def _at(self, x: Any, args: Any) -> Floats:
        """Rows and derivatives at x, those of a few points remembered."""
        point = x.tobytes()
        found = self._known.get(point)
        if found is None:
            rows = 1 + sum(self._counts)
            small = rows * len(x) ** 2 <= _MOST_SECOND
            function = self._compiled.second if small else self._compiled.derivatives
            found = np.asarray(function(x, args))
            if len(self._known) > 3:
                self._known.pop(next(iter(self._known)))
            self._known[point] = found
        return found


AnyFunctions = Functions | CalledFunctions
"""A programme of the dense solver, for JAX's arrays or for NumPy's."""
