"""Windows of a scenario as masks and weights of its intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from jaxatt.problems.scenario_parts import Window
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from jaxatt.problems.scenario import Scenario


def interval_mask(windows: tuple[Window, ...], intervals: int) -> npt.NDArray[np.bool_]:
    mask = np.zeros(intervals, dtype=np.bool_)
    for window in windows:
        mask[window.first : window.last + 1] = True
    return mask


def window_weights(scenario: Scenario) -> Floats:
    """Return the cost of each active interval in moving L0, (N,): h_N of Schaanning (2021), 5.5.

    It is 1 outside the windows; where windows overlap, the later one in the file counts. L0 and
    L1 do not use it.
    """
    weights = np.ones(scenario.horizon.intervals)
    for window in scenario.windows:
        if not window.forbidden:
            weights[window.first : window.last + 1] = window.weight
    return weights


def window_mask(scenario: Scenario) -> npt.NDArray[np.bool_]:
    """Return which intervals lie in a window that is not forbidden, (N,)."""
    allowed = tuple(window for window in scenario.windows if not window.forbidden)
    return interval_mask(allowed, scenario.horizon.intervals)


def forbidden_mask(scenario: Scenario) -> npt.NDArray[np.bool_]:
    """Return which intervals no objective may use, (N,)."""
    forbidden = tuple(window for window in scenario.windows if window.forbidden)
    return interval_mask(forbidden, scenario.horizon.intervals)
