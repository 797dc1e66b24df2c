"""Bounds of the variables, and what is known of all constraints before the first iteration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import certain, namespace, no


class Box(NamedTuple):
    """Bounds on the variables, (n,) each; -inf and inf where there is none."""

    lower: Array
    upper: Array

    def project(self, x: Array) -> Array:
        """The nearest point inside the bounds, of x (n,) or of each of (k, n)."""
        xp, (lower, upper) = namespace(x), self
        if x.ndim == 1:
            return xp.minimum(xp.maximum(x, lower), upper)
        return xp.minimum(xp.maximum(x, lower[None, :]), upper[None, :])


@dataclass(frozen=True)
class Constraints:
    """Bounds and rows of a programme.

    equalities : their number; they are the first rows.  equal : (q,) bool.  most : (q,), inf of
    equalities and 0 of inequalities: the largest violation and the largest multiplier.
    bounded : () bool, there are bounds.  bounds : (), their number.  pinned : (n,) bool, both
    bounds are the same.
    """

    box: Box
    equalities: int
    equal: Array
    most: Array
    bounded: Array
    bounds: Array
    pinned: Array

    @property
    def unbounded(self) -> bool:
        """Whether it is known that there are no bounds."""
        return certain(no(self.bounded))

    def project(self, x: Array) -> Array:
        """The nearest point inside the bounds, of x (n,) or of each of (k, n)."""
        return x if self.unbounded else self.box.project(x)

    def violated(self, rows: Array) -> Array:
        """Rows (q,) where they are violated, zero elsewhere."""
        return namespace(rows).minimum(rows, self.most)


def constraints_of(box: Box, equalities: int, inequalities: int) -> Constraints:
    """Bounds beside so many rows."""
    xp = namespace(box.lower)
    equal = xp.arange(equalities + inequalities) < equalities
    bounds = xp.sum(xp.isfinite(box.lower)) + xp.sum(xp.isfinite(box.upper))
    most = xp.where(equal, xp.inf, 0.0)
    return Constraints(box, equalities, equal, most, bounds > 0, bounds, box.lower >= box.upper)
