"""Merit function of the inner minimisation: augmented Lagrangian, or constraint violation."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import namespace
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
        """First-order multiplier estimates (q,) or (k, q), not positive of inequalities."""
        xp = namespace(rows)
        multipliers, penalty, equal = self.multipliers, self.penalty, self.equal
        if rows.ndim == 2:
            multipliers, equal = multipliers[None, :], equal[None, :]
            penalty = penalty if penalty.ndim == 0 else penalty[None, :]
        free = multipliers + penalty * rows
        return xp.where(equal, free, xp.minimum(free, 0.0))

    def value(self, objective: Array, rows: Array) -> Array:
        """Merit () at evaluated rows (q,), or (k,) at (k, q)."""
        xp = namespace(rows)
        old, penalty = self.multipliers, self.penalty
        if rows.ndim == 2:
            old, penalty = old[None, :], penalty if penalty.ndim == 0 else penalty[None, :]
        shift = (self.estimate(rows) ** 2 - old**2) / (2.0 * penalty)
        return self.weight * objective + xp.sum(shift, axis=-1)

    def gradient(self, at: Local, estimate: Array) -> Array:
        """Gradient (n,) of the merit, given the multiplier estimate (q,)."""
        return self.weight * at.slope + at.jacobian.T @ estimate
