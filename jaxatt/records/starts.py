"""Record of the outcome of all starts of one phase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class StartsRecord:
    """Outcome of every start; leading axis S.

    status : (S,) `jaxatt.optimize.status.Status`.  reached : (S,), by re-simulation.
    active_intervals : (S,).  effort : (S,), L1 effort.  iterations : (S,).
    shortfall : (S,), largest error in units of its tolerance.
    distinct_minima : different answers among the starts that reached the target.
    long_way : (S,), whether it turned the long way round; None where there is but one way.
    """

    status: npt.NDArray[np.int64]
    reached: Flags
    active_intervals: npt.NDArray[np.int64]
    effort: Floats
    iterations: npt.NDArray[np.int64]
    shortfall: Floats
    distinct_minima: int
    long_way: Flags | None = None

    def __repr__(self) -> str:
        return f"StartsRecord({int(self.reached.sum())} of {len(self.reached)} reached)"
