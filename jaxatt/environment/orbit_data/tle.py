"""Two-line elements (TLE)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from sgp4 import io
from sgp4.api import Satrec
from sgp4.earth_gravity import wgs72

from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.orbit_data.path import OrbitDataError

_LENGTH = 69


def looks_like_tle(text: str) -> bool:
    """Whether a text holds a first line of a set with a second one below."""
    lines = [line for line in text.splitlines() if line.strip()]
    return any(a.startswith("1 ") and b.startswith("2 ") for a, b in pairwise(lines))


def read_tle(text: str) -> list[ElementSet]:
    """Every set of a text, with or without a line of the name above it.

    Raises `OrbitDataError`.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    sets = []
    for index, line in enumerate(lines):
        if not line.startswith("1 "):
            continue
        if index + 1 == len(lines) or not lines[index + 1].startswith("2 "):
            raise OrbitDataError(f'"{line[:24]}...": no second line follows; give both lines')
        above = lines[index - 1] if index and not lines[index - 1].startswith("2 ") else ""
        sets.append(element_set((line, lines[index + 1]), above.removeprefix("0 ").strip()))
    if not sets:
        raise OrbitDataError('holds no lines that begin with "1 " and "2 "; give both lines')
    return sets


def element_set(lines: Sequence[str], name: str = "") -> ElementSet:
    """The set of two lines, checked.  Raises `OrbitDataError`."""
    first, second = (line.strip() for line in lines)
    for number, line in enumerate((first, second), start=1):
        _check(line, number)
    if first[2:7] != second[2:7]:
        raise OrbitDataError(
            f"the two lines are of different satellites, {first[2:7]} and {second[2:7]}; give both "
            "of one"
        )
    try:
        # The compiled reader takes whatever it finds in the columns; this one looks.
        io.twoline2rv(first, second, wgs72)
    except ValueError:
        raise OrbitDataError(
            f'"{first[:24]}...": its numbers do not stand in the columns of a TLE; copy both lines '
            "anew, spaces included"
        ) from None
    return ElementSet(name, first[2:7].strip(), Satrec.twoline2rv(first, second))


def _check(line: str, number: int) -> None:
    """Refuse a line of another length, or one whose checksum is wrong."""
    if not line.startswith(f"{number} "):
        raise OrbitDataError(f'line {number} begins with "{line[:2]}"; give line 1, then line 2')
    if len(line) != _LENGTH:
        raise OrbitDataError(
            f"line {number} has {len(line)} characters, not {_LENGTH}; copy it anew, with its "
            "spaces"
        )
    expected = io.compute_checksum(line)
    if line[-1] != str(expected):
        raise OrbitDataError(
            f"the checksum of line {number}, its last character, is {line[-1]} where {expected} "
            "fits the rest: something in the line was changed; copy it anew"
        )
