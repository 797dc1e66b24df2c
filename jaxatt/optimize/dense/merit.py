"""Merit function of the inner minimisation: augmented Lagrangian, or constraint violation."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import namespace
from jaxatt.optimize.dense.local import Local


class Merit(NamedTuple):
    """Augmented Lagrangian with weight () of the objective, multipliers (q,), penalty () or (q,).

    most : (q,), the largest multipliers, inf of equalities and 0 of inequalities.  Weight 0,
    multipliers 0 and penalty 1 / scale^2 make it half the squared violation in the constraints'
    own units.
    """

    weight: Array
    multipliers: Array
    penalty: Array
    most: Array

    def estimate(self, rows: Array) -> Array:
        """First-order multiplier estimates (q,) or (k, q), not positive of inequalities."""
        own = self._like(rows)
        free = own.multipliers + own.penalty * rows
        return namespace(rows).minimum(free, own.most)

    def value(self, objective: Array, rows: Array, estimate: Array) -> Array:
        """Merit () at evaluated rows (q,), or (k,) at (k, q), given the multiplier estimates."""
        own = self._like(rows)
        change, twice = estimate - own.multipliers, estimate + own.multipliers
        shift = namespace(rows).sum(change * twice / own.penalty, axis=-1)
        return self.weight * objective + 0.5 * shift

    def gradient(self, at: Local, estimate: Array) -> Array:
        """Gradient (n,) of the merit, given the multiplier estimate (q,)."""
        return self.weight * at.slope + estimate.dot(at.jacobian)

    def _like(self, rows: Array) -> Merit:
        """This merit, to be applied to rows (q,) or (k, q)."""
        if rows.ndim == 1:
            return self
        penalty = self.penalty if self.penalty.ndim == 0 else self.penalty[None, :]
        return Merit(self.weight, self.multipliers[None, :], penalty, self.most[None, :])
