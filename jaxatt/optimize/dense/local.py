"""Values and first derivatives at a point."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array


class Local(NamedTuple):
    """Scaled values and first derivatives at a point.

    objective : ().  rows : (q,), equalities first.  slope : (n,), the objective's gradient.
    jacobian : (q, n).
    """

    objective: Array
    rows: Array
    slope: Array
    jacobian: Array
