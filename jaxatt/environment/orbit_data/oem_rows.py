"""What is wrong with the rows of an OEM, by line and epoch; the package `oem` does not say."""

from __future__ import annotations

import datetime as dt
import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from jaxatt.environment.epoch import parse
from jaxatt.environment.orbit_data.path import OrbitDataError

_STATE = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
_LENGTHS = (6, 9)
"""Numbers behind an epoch: position and velocity, or these and the acceleration."""
_KEYWORDS = (
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "TIME_SYSTEM",
    "START_TIME",
    "STOP_TIME",
)
_DAY_OF_YEAR = re.compile(r"^(\d{4})-(\d{3})(?=T)")


class Row(NamedTuple):
    """A state as it stands in a file; where : its line, or its epoch, in words."""

    where: str
    segment: int
    epoch: str
    numbers: Sequence[str]


def check_rows(text: str) -> None:
    """Refuse states out of order, repeated or malformed.  Raises `OrbitDataError`."""
    before: tuple[Row, dt.datetime] | None = None
    for row in _in_xml(text) if text.lstrip("\ufeff \t\r\n").startswith("<") else _in_lines(text):
        moment = _moment(row)
        if before is not None:
            _check_order(*before, row, moment)
        before = row, moment
        if len(row.numbers) not in _LENGTHS:
            raise OrbitDataError(
                f"{row.where}: has {len(row.numbers)} numbers behind its epoch, not 6 (position "
                "and velocity) or 9; complete the row or drop it"
            )
        for number in row.numbers:
            if not _is_finite(number):
                raise OrbitDataError(
                    f"{row.where}: {number} is no number; correct the row or drop it"
                )


def _check_order(above: Row, then: dt.datetime, row: Row, moment: dt.datetime) -> None:
    if row.segment == above.segment and moment <= then:
        raise OrbitDataError(
            f"{row.where}: {row.epoch} follows {above.epoch}; the epochs of a segment must "
            "increase: sort its rows and drop repeated ones, or begin a segment of its own"
        )
    if moment < then:
        raise OrbitDataError(
            f"{row.where}: a segment begins at {row.epoch}, before the one above it ends at "
            f"{above.epoch}; put the segments in order, without overlap"
        )


def _moment(row: Row) -> dt.datetime:
    text, day = row.epoch, _DAY_OF_YEAR.match(row.epoch)
    try:
        if day is not None:
            year, number = (int(part) for part in day.groups())
            first = dt.date(year, 1, 1) + dt.timedelta(days=number - 1)
            text = f"{first.isoformat()}{text[day.end() :]}"
        return parse(text)
    except (ValueError, OverflowError):
        raise OrbitDataError(
            f"{row.where}: {row.epoch} is no moment; write it as 2026-06-21T12:00:00.000"
        ) from None


def _is_finite(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _in_lines(text: str) -> Iterator[Row]:
    """The states of a file of keywords and values."""
    block, segment = "header", 0
    known: set[str] = set()
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if not words or words[0] == "COMMENT":
            continue
        if words[0] == "META_START":
            block, segment, known = "metadata", segment + 1, set()
        elif words[0] == "META_STOP":
            block = "states"
            for keyword in _KEYWORDS:
                if keyword not in known:
                    raise OrbitDataError(
                        f"line {number}: {keyword} is missing above; add a line {keyword} = ..., "
                        "as the file's writer can tell"
                    )
        elif words[0] in ("COVARIANCE_START", "COVARIANCE_STOP"):
            block = "covariance" if words[0].endswith("START") else "states"
        elif block == "header" and "=" not in line:
            raise OrbitDataError(
                f"line {number}: {line.strip()[:40]} has no place in an OEM before META_START; put "
                "what says frame and time system above the states, between META_START and META_STOP"
            )
        elif block == "metadata":
            known.add(line.partition("=")[0].strip())
        elif block == "states":
            yield Row(f"line {number}", segment, words[0], words[1:])


def _in_xml(text: str) -> Iterator[Row]:
    """The states of a file in XML."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise OrbitDataError("declares entities of its own; leave them out")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise OrbitDataError(f"is no XML ({error}); write it anew") from None
    for index, segment in enumerate(root.iterfind(".//{*}segment")):
        for state in segment.iterfind(".//{*}stateVector"):
            values = {_local(part): (part.text or "").strip() for part in state}
            epoch = values.get("EPOCH", "")
            numbers = [values[name] for name in _STATE if name in values]
            yield Row(f"the state of {epoch or 'no epoch'}", index, epoch, numbers)


def _local(part: ElementTree.Element) -> str:
    """The name of an element without its namespace."""
    return str(part.tag).rpartition("}")[2]
