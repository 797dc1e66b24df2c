"""What every end of a manoeuvre can do whose attitude may be asked for up to a roll."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self

import numpy as np

from jaxatt.attitude.free_roll import across, facing, spread_rolls
from jaxatt.runtime.arrays import Floats


class EndAttitude(ABC):
    """Attitude and rate to end with.

    boresight : (3,), unit body axis about which the roll is free: of the attitude only where the
    axis points is asked for, and the rate keeps its components in the frame of the attitudes.
    None where the whole attitude is.
    """

    boresight: Floats | None

    @property
    @abstractmethod
    def pose(self) -> tuple[Floats, Floats]:
        """Attitude (..., 4) and rate (..., 3) [rad/s]."""

    @abstractmethod
    def posed(self, q: Floats, rate: Floats) -> Self:
        """The same end with another attitude and rate."""

    @property
    def held(self) -> Floats:
        """Body axes about which the attitude is held, (3, 3), or (2, 3) across the boresight."""
        return np.eye(3) if self.boresight is None else across(self.boresight)

    def facing(self, q: Floats) -> Self:
        """The same end, where its roll is free with the one nearest to attitudes q (..., 4)."""
        if self.boresight is None:
            return self
        return self.posed(*facing(*self.pose, self.boresight, np.asarray(q)))

    def of_starts(self, count: int) -> Self:
        """The end that each of S starts heads for, with attitudes (S, 4) and rates (S, 3).

        Where the roll is free each has its own, spread evenly over a turn; i depends on i only.
        """
        q, rate = (np.asarray(part) for part in self.pose)
        if self.boresight is None:
            return self.posed(np.tile(q, (count, 1)), np.tile(rate, (count, 1)))
        return self.facing(spread_rolls(q, self.boresight, count))
