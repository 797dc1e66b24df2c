"""The final times that were tried where it is free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.records.wording import plural
from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class FinalTimes:
    """The final times that were tried where it is free; leading axis K, in the order of trying.

    time_weight : [1/s], cost of a second in active intervals.  cost : of the answer, with its time.
    final_time : (K,) [s].  costs : (K,), infinite where nothing reached.  active_intervals,
    reached : (K,), of the best answer there.  how : K words, see
    `jaxatt.problems.hands_off.search.time_cost`.
    """

    time_weight: float
    cost: float
    final_time: Floats
    costs: Floats
    active_intervals: npt.NDArray[np.int64]
    reached: Flags
    how: tuple[str, ...]

    def __repr__(self) -> str:
        return f"FinalTimes({plural(len(self.how), 'trial')}, cost {self.cost:.6g})"
