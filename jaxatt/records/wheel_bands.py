"""Record of how the wheels of a flight kept to the speeds that they avoid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class BandRecord:
    """How all wheels kept to one band of speeds in a flight.

    name : its edges in words, "0 to 20 rad/s".  allowed : [s], longest stay; 0 for none at all.
    stays : (n,) [s], longest stay of each wheel within it.
    clearance : (n,) [rad/s], least distance of each wheel from the edge on the side on which it
    began; negative where it went beyond.
    satisfied : whether all wheels kept to it, to one millionth.
    wheels : (n,), their names.
    """

    name: str
    allowed: float
    stays: Floats
    clearance: Floats
    satisfied: bool
    wheels: tuple[str, ...]

    @property
    def outcome(self) -> str:
        """Text of how it was kept, e.g. "longest stay 1.2 s (wheel 3), allowed 2 s"."""
        if self.allowed == 0.0:
            i = int(np.argmin(self.clearance))
            away = max(0.0, self.clearance[i]) if self.satisfied else self.clearance[i]
            words = f"{away:.4g} rad/s away" if away >= 0.0 else f"{-away:.7g} rad/s inside"
            return f"{self.wheels[i]} comes nearest, {words}"
        i = int(np.argmax(self.stays))
        return f"longest stay {self.stays[i]:.4g} s ({self.wheels[i]}), allowed {self.allowed:g} s"
