"""Objective and constraints of a small programme: stacked, scaled and differentiated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.dense.merit import Merit

Function = Callable[..., Any]


@dataclass(frozen=True)
class Functions:
    """Objective and constraints as callables of (x, *args), compared by identity.

    objective : () to minimise.  equality : zero when met.  inequality : non-negative when met;
    both a scalar, (m,) or None.
    """

    objective: Function
    equality: Function | None = None
    inequality: Function | None = None

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support."""
        asked = {
            features.EQUALITY: self.equality is not None,
            features.INEQUALITY: self.inequality is not None,
        }
        return frozenset(name for name, there in asked.items() if there) | {features.FEW_VARIABLES}

    def parts(self, x: Array, args: Any) -> tuple[Array, Array, Array]:
        """Objective (), equalities (m,) and inequalities (p,) at x, (n,)."""
        none = jnp.zeros((0,), x.dtype)
        return (
            jnp.asarray(self.objective(x, *args), x.dtype).reshape(()),
            none if self.equality is None else _rows(self.equality(x, *args), x),
            none if self.inequality is None else _rows(self.inequality(x, *args), x),
        )

    def rows(self, x: Array, args: Any) -> Array:
        """Objective, equalities and inequalities stacked, (1 + q,)."""
        objective, equality, inequality = self.parts(x, args)
        return jnp.concatenate([objective[None], equality, inequality])

    def merits(self, points: Array, args: Any, scale: Array, merit: Merit) -> Array:
        """Merit (k,) of the rows times `scale`, (1 + q,), at points (k, n).

        It is inf where anything is not finite.
        """
        rows = jax.vmap(lambda x: self.rows(x, args))(points) * scale[None, :]
        values = merit.value(rows[:, 0], rows[:, 1:], merit.estimate(rows[:, 1:]))
        # A row that is not finite may pass for one that holds: XLA's maximum drops it.
        all_of_it = values + jnp.sum(rows, axis=1) + jnp.sum(points, axis=1)
        return jnp.where(jnp.isfinite(all_of_it), values, jnp.inf)

    def derivatives(self, x: Array, args: Any) -> tuple[Array, Array]:
        """Stacked rows (1 + q,) and their derivatives (1 + q, n)."""
        return jacobian(lambda y: self.rows(y, args), x)

    def hessian(self, x: Array, args: Any, weights: Array) -> Array:
        """Second derivatives (n, n) of the sum of rows with weights (1 + q,)."""
        return jax.hessian(lambda y: weights @ self.rows(y, args))(x)

    def second_derivatives(self, x: Array, args: Any) -> tuple[Array, Array, Array]:
        """Stacked rows, their first and their second derivatives, (1 + q, n, n)."""

        def first(y: Array) -> tuple[Array, tuple[Array, Array]]:
            rows, derivatives = self.derivatives(y, args)
            return derivatives, (rows, derivatives)

        second, (rows, derivatives) = jax.jacfwd(first, has_aux=True)(x)
        return rows, derivatives, second

    def counts(self, x: Array, args: Any) -> tuple[int, int]:
        """Number of equalities and inequalities."""
        _, equality, inequality = jax.eval_shape(self.parts, x, args)
        return equality.shape[0], inequality.shape[0]


def _rows(values: Any, x: Array) -> Array:
    return jnp.atleast_1d(jnp.asarray(values, x.dtype))


def jacobian(function: Callable[[Array], Array], x: Array) -> tuple[Array, Array]:
    """Values (m,) and derivatives (m, n), by forward or reverse mode, whichever is cheaper."""
    count = jax.eval_shape(function, x).shape[0]
    if count <= x.shape[0]:
        values, pullback = jax.vjp(function, x)
        return values, jax.vmap(lambda row: pullback(row)[0])(jnp.eye(count, dtype=x.dtype))
    values, push = jax.linearize(function, x)
    return values, jax.vmap(push)(jnp.eye(x.shape[0], dtype=x.dtype)).T
