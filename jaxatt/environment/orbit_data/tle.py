"""Two-line elements (TLE)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from sgp4 import io
from sgp4.api import Satrec
from sgp4.earth_gravity import wgs72

from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.orbit_data.path import OrbitDataError

_LENGTH = 69
_ALONE = re.compile(r"^[12] [0-9A-Z ]{5}[A-Z ] .{50,}$")
"""A line of a set, by what stands at its beginning and how long it is."""


def looks_like_tle(text: str) -> bool:
    """Whether a text holds both lines of a set one below the other, or one of them alone."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if any(a.startswith("1 ") and b.startswith("2 ") for a, b in pairwise(lines)):
        return True
    return any(_ALONE.match(line) for line in lines[:3])


def read_tle(text: str, wanted: str = "") -> list[ElementSet]:
    """The sets of a text, with or without a line of the name above each.

    wanted : name or number of the only object whose lines matter; all do if it is not there.
    Raises `OrbitDataError`.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    found: list[tuple[str, str, str]] = []
    for index, line in enumerate(lines):
        if not line.startswith("1 "):
            continue
        if index + 1 == len(lines) or not lines[index + 1].startswith("2 "):
            raise OrbitDataError(f'"{line[:24]}...": no second line follows; give both lines')
        above = lines[index - 1] if index and not lines[index - 1].startswith("2 ") else ""
        found.append((line, lines[index + 1], above.removeprefix("0 ").strip()))
    if not found:
        raise OrbitDataError('holds no lines that begin with "1 " and "2 "; give both lines')
    asked = wanted.strip().lower()
    fitting = [each for each in found if asked in (each[2].lower(), each[0][2:7].strip().lower())]
    return [element_set(each[:2], each[2]) for each in (fitting if asked else []) or found]


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
        satrec = Satrec.twoline2rv(first, second)
    except (ValueError, TypeError, ArithmeticError):
        raise OrbitDataError(
            f'"{first[:24]}...": its numbers do not stand in the columns of a TLE, or are of no '
            "orbit; copy both lines anew, with their spaces"
        ) from None
    return ElementSet(name, first[2:7].strip(), satrec)


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
