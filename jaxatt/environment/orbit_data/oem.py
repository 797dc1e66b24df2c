"""Orbit Ephemeris Messages (OEM) of the CCSDS, read by the package `oem`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.environment.ephemeris import States
from jaxatt.environment.epoch import SECONDS_PER_DAY, moment_text
from jaxatt.environment.orbit_data.hermite import Hermite
from jaxatt.environment.orbit_data.j2 import Propagation, pole_of_date
from jaxatt.environment.orbit_data.oem_rows import check_rows
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.teme import inertial_of_earth_fixed, inertial_of_teme
from jaxatt.runtime.arrays import Floats

_J2000 = 2451545.0  # [days], Julian date
_TIME_SYSTEMS = ("UTC", "TAI", "TT", "TDB")
_WIDER = 3.5
"""How many times wider than its neighbours a step between two states is a gap."""
_WIDEST = 0.5  # [rad] of the orbit, beyond which a step is a gap
_NEAREST, _FARTHEST, _FASTEST = 6.3e6, 1e9, 12e3  # [m], [m], [m/s]
_ROUNDING = 1e-3  # [s], of the moment at which a motion begins or ends

Turn = Callable[[Floats, Floats, Floats], tuple[Floats, ...]]
_FRAMES: Mapping[str, Turn] = {
    "EME2000": lambda days, r, v: (r, v),
    "J2000": lambda days, r, v: (r, v),
    "GCRF": lambda days, r, v: (r, v),
    "ICRF": lambda days, r, v: (r, v),
    "TEME": inertial_of_teme,
    "TEMEOFDATE": inertial_of_teme,
    "ITRF": inertial_of_earth_fixed,
}
"""Frames of files; the celestial reference frame is within 0.03 arcsec of the inertial one."""


@dataclass(frozen=True, eq=False)
class Piece:
    """States without a gap, in inertial axes.

    days : a moment, since J2000.  times : (n,) [s] after it.  r : (n, 3) [m].  v : (n, 3) [m/s].
    first, last : [s], between which they may be used.
    """

    days: float
    times: Floats
    r: Floats
    v: Floats
    first: float
    last: float

    @property
    def span(self) -> tuple[float, float]:
        """Days since J2000 between which the states may be used."""
        begin, end = (self.days + time / SECONDS_PER_DAY for time in (self.first, self.last))
        return begin, end


@dataclass(frozen=True, eq=False)
class EphemerisTable:
    """States of a file in pieces between which there are gaps; an `OrbitPath`.

    name, number : of the object.  frame : the file's.
    """

    name: str
    number: str
    frame: str
    pieces: tuple[Piece, ...]

    @property
    def title(self) -> str:
        """Name and number, for messages."""
        return f"{self.name} ({self.number})"

    @property
    def epoch(self) -> float:
        """Moment of the first state, days since J2000."""
        return self.pieces[0].span[0]

    def lasts(self, days: float) -> float:
        """Time [s] from a moment to the next gap, or the end; 0 where there are no states then."""
        spans = [piece.span for piece in self.pieces]
        ends = [end for begin, end in spans if begin - _ROUNDING / SECONDS_PER_DAY <= days <= end]
        return (max(ends) - days) * SECONDS_PER_DAY if ends else 0.0

    def over(self, days: float, first: float, last: float) -> States:
        """States between those of the file; what is asked outside goes on with J2."""
        begin, end = (days + time / SECONDS_PER_DAY for time in (first, last))
        slack = _ROUNDING / SECONDS_PER_DAY
        for piece in self.pieces:
            if piece.span[0] - slack <= begin and end <= piece.span[1] + slack:
                return _continued(piece, (days - piece.days) * SECONDS_PER_DAY)
        spans = "; ".join(" to ".join(map(moment_text, piece.span)) for piece in self.pieces[:5])
        more = f" and {len(self.pieces) - 5} more spans" if len(self.pieces) > 5 else ""
        raise OrbitDataError(
            f"the motion from {moment_text(begin)} to {moment_text(end)} is not within states "
            f"without a gap, which are from {spans}{more}; begin at another epoch, end before, or "
            "give a file that covers it"
        )


def _continued(piece: Piece, later: float) -> States:
    between = Hermite(piece.times, piece.r, piece.v)
    pole = pole_of_date(piece.days)
    beyond = {end: Propagation(piece.r[end], piece.v[end], pole) for end in (0, -1)}

    def states(times: Floats) -> tuple[Floats, Floats]:
        own = later + times
        r, v = between(np.clip(own, piece.times[0], piece.times[-1]))
        for end, outside in ((0, own < piece.times[0]), (-1, own > piece.times[-1])):
            if outside.any():
                away = own[outside] - piece.times[end]
                r[outside], v[outside] = beyond[end](away)
        return r, v

    return states


def looks_like_oem(text: str) -> bool:
    """Whether a text begins as an OEM."""
    head = text.lstrip("\ufeff \t\r\n")[:2000]
    return head.startswith("CCSDS_OEM_VERS") or (head.startswith("<") and "<oem" in head.lower())


def read_oem(path: Path) -> EphemerisTable:
    """The states of a file, in KVN or XML.  Raises `OrbitDataError`."""
    check_rows(path.read_text(encoding="utf-8-sig"))
    # Astropy, which the package brings along, takes a while to import.
    from oem import OrbitEphemerisMessage

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            segments = list(OrbitEphemerisMessage.open(path))
            pieces = tuple(piece for segment in segments for piece in _pieces(segment))
    except OrbitDataError:
        raise
    except Exception as error:
        reason = str(error).partition("\n")[0].strip("'\" :") or type(error).__name__
        raise OrbitDataError(f"is no OEM that can be read ({reason}); write it anew") from None
    if not pieces:
        raise OrbitDataError("has no two states without a gap between them; write it anew")
    about = segments[0].metadata
    return EphemerisTable(about["OBJECT_NAME"], about["OBJECT_ID"], about["REF_FRAME"], pieces)


def _pieces(segment: Any) -> list[Piece]:
    """The states of a segment in inertial axes, divided at gaps."""
    from astropy.time import Time

    about = segment.metadata
    turn = _turn(about["REF_FRAME"])
    if about["CENTER_NAME"].upper() != "EARTH":
        raise OrbitDataError(
            f"CENTER_NAME is {about['CENTER_NAME']}, and only motion about the Earth can be read; "
            "give a file with CENTER_NAME = EARTH"
        )
    scale = about["TIME_SYSTEM"].upper()
    if scale not in _TIME_SYSTEMS:
        raise OrbitDataError(
            f"TIME_SYSTEM is {scale}, which is not known; give times in one of "
            f"{', '.join(_TIME_SYSTEMS)}"
        )
    states = list(segment.states)
    if len(states) < 2:
        raise OrbitDataError("has a segment of one state; give two at least")
    parts = np.array([(state.epoch.jd1, state.epoch.jd2) for state in states])
    moments = Time(parts[:, 0], parts[:, 1], format="jd", scale=scale.lower()).utc
    begin = moments[0]
    first = float(begin.jd1 - _J2000 + begin.jd2)

    def since(some: Any) -> Floats:
        return SECONDS_PER_DAY * np.asarray((some.jd1 - begin.jd1) + (some.jd2 - begin.jd2), float)

    times = since(moments)
    r = 1e3 * np.array([state.position for state in states], float)
    v = 1e3 * np.array([state.velocity for state in states], float)
    radius, speed = np.linalg.norm(r, axis=1), np.linalg.norm(v, axis=1)
    if not ((radius > _NEAREST) & (radius < _FARTHEST) & (speed < _FASTEST)).all():
        raise OrbitDataError(
            f"holds states {1e-3 * radius.min():.6g} to {1e-3 * radius.max():.6g} km from the "
            f"Earth's centre at up to {1e-3 * speed.max():.6g} km/s, which are on no orbit; give "
            "kilometres and kilometres a second"
        )
    r, v = turn(first + times / SECONDS_PER_DAY, r, v)
    usable = since(Time([segment.useable_start_time, segment.useable_stop_time]).utc)
    found = []
    for rows in _runs(times, r, v):
        own = times[rows]
        limits = np.clip(usable, own[0], own[-1]).tolist()
        if limits[1] > limits[0]:
            found.append(Piece(first, own, r[rows], v[rows], *limits))
    return found


def _runs(times: Floats, r: Floats, v: Floats) -> list[slice]:
    """Rows of the states between one gap and the next."""
    steps = np.diff(times)
    beside = np.maximum(np.append(steps[1:], 0.0), np.insert(steps[:-1], 0, 0.0))
    angles = steps * np.linalg.norm(np.cross(r, v), axis=1)[:-1] / np.square(r).sum(axis=1)[:-1]
    wide = angles > _WIDEST
    if len(steps) > 1:
        wide |= steps > _WIDER * beside
    edges = [0, *(np.flatnonzero(wide) + 1).tolist(), len(times)]
    return [slice(*pair) for pair in pairwise(edges) if pair[1] - pair[0] > 1]


def _turn(name: str) -> Turn:
    frame = "ITRF" if name.upper().startswith("ITRF") else name.upper()
    if frame not in _FRAMES:
        raise OrbitDataError(
            f"REF_FRAME is {name}, which is not known; give states in one of {', '.join(_FRAMES)}"
        )
    return _FRAMES[frame]
