"""What every CasADi side offers to the worker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Attempt:
    """How one start ended.

    controls : (N, b) in the task's axes, [N m] for a slew.
    status : the solver's own word.  iterations : of all solves of the start together.
    """

    controls: Floats
    status: str
    iterations: int


Solve = Callable[[int], Attempt]
"""From the index of a start to how it ended."""
