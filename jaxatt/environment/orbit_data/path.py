"""What the host knows of an orbit that is not an ellipse."""

from __future__ import annotations

from typing import Protocol

from jaxatt.environment.ephemeris import States


class OrbitDataError(ValueError):
    """Orbit data that cannot be used: the message says why, and how to mend it."""


class OrbitPath(Protocol):
    """An orbit whose position and velocity are known on the host."""

    def over(self, days: float, first: float, last: float) -> States:
        """States in inertial axes at times [s] after a moment, between `first` and `last`.

        days : the moment, since J2000.  What is returned can be asked somewhat outside, too.
        Raises `OrbitDataError` where the orbit is not known in between.
        """
        ...
