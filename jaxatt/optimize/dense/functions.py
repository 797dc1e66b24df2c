"""Objective and constraints of a small programme: stacked, scaled and differentiated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.dense.arrays import namespace

Function = Callable[..., Any]

_LARGEST_SLOPE = 100.0
_SMALLEST_SCALE = 1e-8


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

    def many(self, points: Array, args: Any) -> Array:
        """Stacked rows (k, 1 + q) at points (k, n)."""
        return jax.vmap(lambda x: self.rows(x, args))(points)

    def derivatives(self, x: Array, args: Any) -> tuple[Array, Array]:
        """Stacked rows (1 + q,) and their derivatives (1 + q, n)."""
        return jacobian(lambda y: self.rows(y, args), x)

    def hessian(self, x: Array, args: Any, weights: Array) -> Array:
        """Second derivatives (n, n) of the sum of rows with weights (1 + q,)."""
        return jax.hessian(lambda y: weights @ self.rows(y, args))(x)

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


class Local(NamedTuple):
    """Scaled values and first derivatives at a point.

    objective : ().  rows : (q,), equalities first.  slope : (n,), the objective's gradient.
    jacobian : (q, n).
    """

    objective: Array
    rows: Array
    slope: Array
    jacobian: Array

    @property
    def finite(self) -> Array:
        """Whether all values and derivatives are finite."""
        xp = namespace(self.rows)
        own = [xp.all(xp.isfinite(leaf)) for leaf in self]
        return own[0] & own[1] & own[2] & own[3]


def scale_of(derivatives: Array) -> Array:
    """Factors that limit the gradient of every row to 100, as IPOPT does.

    derivatives : (1 + q, n) at the start.  Source: Waechter & Biegler (2006), section 3.8.
    """
    xp = namespace(derivatives)
    steepest = xp.max(abs(derivatives), axis=1)
    steepest = xp.where(xp.isfinite(steepest), steepest, 1.0)
    return xp.maximum(_SMALLEST_SCALE, xp.minimum(1.0, _LARGEST_SLOPE / steepest))
