"""Merit function of the inner minimisation: augmented Lagrangian, or constraint violation."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.augmented_lagrangian.penalty import pushed
from jaxatt.optimize.dense.functions import Local


class Merit(NamedTuple):
    """Augmented Lagrangian with weight () of the objective, multipliers (q,) and penalty (q,).

    equal : (q,) bool.  Weight 0, multipliers 0 and penalty 1 / scale^2 make it half the squared
    violation in the constraints' own units.
    """

    weight: Array
    multipliers: Array
    penalty: Array
    equal: Array

    def estimate(self, rows: Array) -> Array:
        """First-order multiplier estimates (q,); those of inequalities are not positive."""
        free = self.multipliers + self.penalty * rows
        return jnp.where(self.equal, free, -pushed(-self.multipliers, self.penalty, rows))

    def value(self, objective: Array, rows: Array) -> Array:
        """Merit () at evaluated rows."""
        shift = (self.estimate(rows) ** 2 - self.multipliers**2) / (2.0 * self.penalty)
        return self.weight * objective + jnp.sum(shift)

    def gradient(self, at: Local, estimate: Array) -> Array:
        """Gradient (n,) of the merit, given the multiplier estimate (q,)."""
        return self.weight * at.slope + at.jacobian.T @ estimate
