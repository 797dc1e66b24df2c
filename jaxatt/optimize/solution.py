"""Result of one start, the same for every solver that minimises."""

from __future__ import annotations

from typing import Any, NamedTuple

from jax import Array


class Solution(NamedTuple):
    """Result of one start; a batch has one more leading axis.

    x : (N, b), variables or controls.  objective : () at the final smoothing.
    status : () a `Status`.  violation : () largest constraint violation at x.
    stationarity : () scaled norm of the Lagrangian's gradient where it was last evaluated, which is
    x if the status is CONVERGED.  multipliers : those whose stationarity was tested.
    iterations : () passes.  states : (N + 1, s), of a programme in stages; () of others.
    """

    x: Array
    objective: Array
    status: Array
    violation: Array
    stationarity: Array
    multipliers: Any
    iterations: Array
    states: Any = ()
