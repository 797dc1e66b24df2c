"""Orbits of SGP4: mean elements that only this theory turns into positions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sgp4.api import SGP4_ERRORS, WGS72, Satrec

from jaxatt.environment.ephemeris import States
from jaxatt.environment.epoch import SECONDS_PER_DAY
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.sun import EARTH_RADIUS
from jaxatt.environment.teme import inertial_of_teme
from jaxatt.runtime.arrays import Floats

_J2000 = 2451545.0
_FRESH = 1000.0  # [m], by which a set is off at its own epoch
_DRIFT = 2000.0  # [m] a day
_DRAG = 0.1  # by which the drag over days is not known
_DRAG_DAYS = 3.0  # over which its effect is computed
_LOST = EARTH_RADIUS
"""[m] Beyond which elements no longer say where a satellite is."""
FRESH_DAYS = 7.0
"""Age beyond which a set is warned about."""


@dataclass(frozen=True, eq=False)
class ElementSet:
    """One set of mean elements of SGP4, from a TLE or an OMM; an `OrbitPath`.

    name, number : of the satellite, the second in the catalogue.
    """

    name: str
    number: str
    satrec: Satrec

    @property
    def epoch(self) -> float:
        """Epoch of the set, days since J2000."""
        return float((self.satrec.jdsatepoch - _J2000) + self.satrec.jdsatepochF)

    @property
    def title(self) -> str:
        """Name and number, for messages."""
        return f"{self.name} ({self.number})" if self.name else self.number

    def over(self, days: float, first: float, last: float) -> States:
        """States by SGP4, in inertial axes; refused where the theory does not hold."""
        if self.off_by(days) > _LOST:
            raise OrbitDataError(
                f"the elements of {self.title} are {self._aged(days)}: the orbit may be off by "
                "more than the Earth's radius; take elements of about that date"
            )
        whole, part = np.floor(days), days - np.floor(days)

        def states(times: Floats) -> tuple[Floats, Floats]:
            fraction = part + times / SECONDS_PER_DAY
            codes, r, v = self.satrec.sgp4_array(np.full(len(times), _J2000 + whole), fraction)
            if codes.any():
                self._refuse(int(codes[codes > 0][0]), days)
            r, v = inertial_of_teme(whole + fraction, 1e3 * r, 1e3 * v)
            return r, v

        states(np.asarray([first, last]))
        return states

    def _aged(self, days: float) -> str:
        side = "old" if days > self.epoch else "ahead"
        return f"{abs(days - self.epoch):.1f} days {side} at the start"

    def _refuse(self, code: int, days: float) -> None:
        raise OrbitDataError(
            f"SGP4 does not propagate the elements of {self.title}, {self._aged(days)}: "
            f"{SGP4_ERRORS[code]}; take elements of about that date"
        )

    def off_by(self, days: float) -> float:
        """By how much [m] the position may be off at a moment, days since J2000.

        A kilometre at the epoch and two a day (1 to 3 are usual, says the documentation of
        `sgp4`), and what a tenth more drag would change, along the track.
        """
        age = abs(days - self.epoch)
        own, other = self.satrec, Satrec()
        other.sgp4init(
            WGS72,
            "i",
            own.satnum,
            own.jdsatepoch + own.jdsatepochF - 2433281.5,
            own.bstar * (1.0 + _DRAG),
            own.ndot,
            own.nddot,
            own.ecco,
            own.argpo,
            own.inclo,
            own.mo,
            own.no_kozai,
            own.nodeo,
        )
        # With the square of the time, as the mean motion changes; far away the theory may fail.
        near = min(age, _DRAG_DAYS)
        then = self.epoch + math.copysign(near, days - self.epoch)
        places = [set_.sgp4(_J2000, then)[1] for set_ in (own, other)]
        drag = 1e3 * math.dist(*places) * (age / near) ** 2 if near else 0.0
        return _FRESH + _DRIFT * age + drag

    def warning(self, days: float) -> str:
        """Sentence about the age of the set at a moment; empty where it is fresh."""
        if abs(days - self.epoch) <= FRESH_DAYS:
            return ""
        return (
            f"the elements of {self.title} are {self._aged(days)}: the orbit may be off by about "
            f"{1e-3 * self.off_by(days):.0f} km; take elements of about that date"
        )


def choose(sets: Sequence[ElementSet], wanted: str, days: float | None) -> ElementSet:
    """The set of a satellite: the only one, or that of a name or number, nearest to a moment.

    wanted : name or catalogue number; "" where all sets are of one satellite.
    days : since J2000; None for the newest.  Raises `OrbitDataError`.
    """
    fitting = [s for s in sets if wanted.strip().lower() in (s.name.lower(), s.number.lower())]
    if not wanted:
        fitting = list(sets)
        if len({s.number for s in fitting}) > 1:
            raise OrbitDataError(
                f"holds {len(sets)} sets of several satellites ({_listed(sets)}); name one of them "
                "as object"
            )
    if not fitting:
        raise OrbitDataError(
            f'holds no object "{wanted}" but {_listed(sets)}; name one of them, or its number'
        )
    return min(fitting, key=lambda s: -s.epoch if days is None else abs(s.epoch - days))


def _listed(sets: Sequence[ElementSet]) -> str:
    titles = list(dict.fromkeys(s.title for s in sets))
    return ", ".join(titles[:5]) + (", ..." if len(titles) > 5 else "")
