"""Which of the known forms a file of an orbit has."""

from __future__ import annotations

import functools
from pathlib import Path

from jaxatt.environment.orbit_data.element_set import ElementSet, choose
from jaxatt.environment.orbit_data.oem import EphemerisTable, looks_like_oem, read_oem
from jaxatt.environment.orbit_data.omm import looks_like_omm, read_omm
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.orbit_data.tle import looks_like_tle, read_tle

KINDS = ("tle", "omm", "oem")


def kind_of(text: str) -> str | None:
    """One of `KINDS`, by what a text begins with; None for another text."""
    for kind, fits in zip(KINDS, (looks_like_tle, looks_like_omm, looks_like_oem), strict=True):
        if fits(text):
            return kind
    return None


def text_of(path: Path) -> str:
    """The text of a file.  Raises `OrbitDataError`."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeError:
        raise OrbitDataError("is not a text file in UTF-8; save it as text") from None
    except OSError as error:
        raise OrbitDataError(
            f"cannot be read ({error.strerror or error}); check the path"
        ) from None
    except ValueError:
        raise OrbitDataError("is no path of a file; check the path") from None


def read_orbit_file(
    path: Path, kind: str, wanted: str = "", days: float | None = None
) -> ElementSet | EphemerisTable:
    """The orbit in a file.

    kind : one of `KINDS`, which the file must be.
    wanted : name or number of the object, where a file holds several.
    days : moment, since J2000, to which the nearest of several sets is taken; None for the newest.
    Raises `OrbitDataError`.
    """
    text = text_of(path)
    found = kind_of(text)
    if found not in (kind, None):
        raise OrbitDataError(
            f"holds an orbit as {found.upper()}, not as {kind.upper()}; use {found}_file"
        )
    if kind == "oem":
        stamp = path.stat()
        return _table(path.resolve(), stamp.st_mtime_ns, stamp.st_size)
    sets = read_tle(text, wanted) if kind == "tle" else read_omm(text)
    return choose(sets, wanted, days)


@functools.lru_cache(maxsize=8)
def _table(path: Path, changed: int, size: int) -> EphemerisTable:
    """A scenario that is changed is read again, and a long ephemeris takes seconds."""
    return read_oem(path)
