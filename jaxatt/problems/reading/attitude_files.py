"""Read the key `aem_file` of a table: attitudes in a CCSDS Attitude Ephemeris Message."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.environment import epoch
from jaxatt.exchange.attitude_file import path_of
from jaxatt.exchange.motion import FileFormatError
from jaxatt.problems.reading.dates import moment_of
from jaxatt.problems.reading.fields import Table


def read_path(
    table: Table, folder: Path | None, days: float | None, first: float, last: float
) -> AttitudePath:
    """Read the path of the file that a table names, with times from the scenario's start.

    folder : where the file is looked up; None for the working folder.
    days : epoch of the scenario, since J2000, None where it has none; `at` comes first.
    first, last : [s], which the file is to cover; the same for one instant.
    """
    start = _start(table, days)
    try:
        return path_of((folder or Path()) / table.text("aem_file"), start, first, last)
    except FileFormatError as error:
        table.fail("aem_file", f"{error.where}: {error.problem}", error.mend)


def refuse_beside_file(table: Table, keys: tuple[str, ...]) -> None:
    """Refuse keys beside `aem_file` that say what the file says."""
    for key in keys:
        if key in table:
            table.fail(key, "given beside aem_file, which says it", "keep one of the two")


def _start(table: Table, days: float | None) -> dt.datetime:
    if "at" not in table:
        if days is None:
            table.fail(
                "at",
                "missing, and there is no epoch to take in its place",
                'add a line such as at = "2026-06-21T12:00:00Z", when the file is read',
            )
        return moment_of(days)
    try:
        return epoch.parse(table.text("at"))
    except (ValueError, OverflowError):
        table.fail("at", "is no moment", 'write it as "2026-06-21T12:00:00Z"')
