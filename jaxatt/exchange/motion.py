"""What attitude and orbit files hold, as plain data."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass

from jaxatt.runtime.arrays import Floats

FRAME = "EME2000"
"""The inertial frame of the package, as CCSDS calls it."""


class FileFormatError(ValueError):
    """A file of another tool that cannot be used: where, the problem, and the mend."""

    def __init__(self, where: str, problem: str, mend: str) -> None:
        super().__init__(f"{where}: {problem}; {mend}")
        self.where, self.problem, self.mend = where, problem, mend


@dataclass(frozen=True)
class Named:
    """Whose motion a file holds, and who made it.

    designator : international, such as "2022-002B".
    """

    name: str
    designator: str = "UNKNOWN"
    originator: str = "JAXATT"


@dataclass(frozen=True, eq=False)
class AttitudeHistory:
    """Attitude of a body relative to inertial axes (EME2000).

    epoch : UTC of time zero.  time : (n,) [s], increasing.  q_ib : (n, 4), scalar first.
    omega_ib : (n, 3) [rad/s], in body axes.
    """

    epoch: dt.datetime
    time: Floats
    q_ib: Floats
    omega_ib: Floats


@dataclass(frozen=True, eq=False)
class OrbitHistory:
    """Motion about the Earth in inertial axes (EME2000).

    epoch : UTC of time zero.  time : (n,) [s], increasing.  position : (n, 3) [m].
    velocity : (n, 3) [m/s].
    """

    epoch: dt.datetime
    time: Floats
    position: Floats
    velocity: Floats
