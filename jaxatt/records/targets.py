"""Record of the best answers to many targets of one scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class TargetAnswers:
    """The best answer to each of M targets, flown again.

    reached : (M,), whether its flight reaches the target, with the error of the flight itself known
    to be small.  numbers : name and unit as in `summary.json` -> (M,); not a number where there is
    none.  controls : (M, N, b), held over each interval, as `Phase.controls`.  step : (M,) [s].
    """

    reached: Flags
    numbers: Mapping[str, Floats]
    controls: Floats
    step: Floats

    @staticmethod
    def join(parts: list[TargetAnswers]) -> TargetAnswers:
        """Concatenate answers to several sets of targets."""
        return TargetAnswers(
            np.concatenate([part.reached for part in parts]),
            {
                name: np.concatenate([part.numbers[name] for part in parts])
                for name in parts[0].numbers
            },
            np.concatenate([part.controls for part in parts]),
            np.concatenate([part.step for part in parts]),
        )
