"""Nonlinear programme whose variables come in stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features


def _no_rows(x: Array, args: Any) -> Array:
    return jnp.zeros((0,), x.dtype)


def _no_stage_rows(x: Array, args: Any) -> Array:
    return jnp.zeros((x.shape[0], 0), x.dtype)


def _all_free(x: Array, args: Any) -> Array:
    return jnp.ones_like(x)


def _all_hard(x: Array, args: Any) -> Array:
    return jnp.full((), jnp.inf, x.dtype)


@dataclass(frozen=True)
class Program:
    """A nonlinear programme as pure functions of variables x, (N, b), and of a pytree `args`.

    Everything that can change from one solve to the next belongs in `args`, so that a new value
    never recompiles.

    objective : (x, args, smoothing) -> ().
    curvature : (x, args, smoothing) -> (N, b, b), a positive semidefinite block of curvature for
        every stage; it may majorise the objective rather than be its Hessian.
    equality : (x, args) -> (m,), zero when satisfied.
    equality_weight : (x, args) -> (m,) or (); a finite entry w makes that row soft, costing
        w/2 row^2 instead of being enforced; inf makes it hard.
    inequality : (x, args) -> (p,), non-negative when satisfied; may couple all stages.
    stage_inequality : (x, args) -> (N, q), non-negative; row k depends on x[k] only.
    free : (x, args) -> (N, b), 1 where the variable may move and 0 where it is held.
    """

    objective: Callable[[Array, Any, Array], Array]
    curvature: Callable[[Array, Any, Array], Array]
    equality: Callable[[Array, Any], Array] = _no_rows
    equality_weight: Callable[[Array, Any], Array] = _all_hard
    inequality: Callable[[Array, Any], Array] = _no_rows
    stage_inequality: Callable[[Array, Any], Array] = _no_stage_rows
    free: Callable[[Array, Any], Array] = _all_free

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support."""
        asked = {
            features.EQUALITY: self.equality is not _no_rows,
            features.SOFT_ROWS: self.equality_weight is not _all_hard,
            features.INEQUALITY: self.inequality is not _no_rows,
            features.STAGE_INEQUALITY: self.stage_inequality is not _no_stage_rows,
            features.HELD_VARIABLES: self.free is not _all_free,
        }
        return frozenset(name for name, there in asked.items() if there) | {
            features.WITHOUT_DYNAMICS
        }
