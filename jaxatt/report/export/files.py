"""Write the motion of a saved result into files that other tools read."""

from __future__ import annotations

import datetime as dt
import math
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.aem_xml import aem_xml
from jaxatt.exchange.motion import AttitudeHistory, Named, OrbitHistory
from jaxatt.exchange.oem import oem_text
from jaxatt.exchange.stk import stk_text
from jaxatt.exchange.table import csv_text
from jaxatt.problems.along_orbit import along_orbit
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.export.saved_motion import SavedMotion
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import filling

_ROWS_AN_INTERVAL = 10
_ORBIT_STEP = 10.0
"""[s] between the rows of an orbit, at most; there are `_ORBIT_ROWS` at least."""
_ORBIT_ROWS = 16
MOST_ROWS = 2_000_000


class Format(StrEnum):
    """Format of an attitude file."""

    aem = "aem"
    aem_1 = "aem-1"
    aem_xml = "aem-xml"
    stk = "stk"
    csv = "csv"


_ENDINGS = {
    Format.aem: ".aem",
    Format.aem_1: ".aem",
    Format.aem_xml: ".aem.xml",
    Format.stk: ".a",
    Format.csv: ".csv",
}


class Exported(NamedTuple):
    """A file that was written, and words on what is in it."""

    path: Path
    contents: str


def write_files(
    motion: SavedMotion,
    folder: str | Path,
    form: Format = Format.aem,
    *,
    epoch: dt.datetime | None = None,
    step: float | None = None,
    orbit: bool = False,
    named: Named | None = None,
) -> list[Exported]:
    """Write an attitude file, and with `orbit` an OEM; arguments as of `export`."""
    start = epoch or motion.epoch
    if start is None:
        raise ScenarioError(
            f"{motion.name}: has no epoch, and such files need the date; give one, as in --epoch "
            "2026-06-21T12:00:00Z, or under [orbit] before it is solved"
        )
    if orbit and motion.orbit is None:
        raise ScenarioError(f"{motion.name}: has no orbit; leave --orbit out")
    named = named or Named(motion.name)
    histories = [
        AttitudeHistory(start, time, *path.at(time))
        for path, time in ((path, _rows(path, step)) for path in motion.paths)
    ]
    name = f"{motion.name}{_ENDINGS[form]}"
    contents = {name: _text(form, histories, named)}
    rows = sum(len(history.time) for history in histories)
    words = {name: f"{rows} attitudes from {_span(histories)}, EME2000 to body"}
    if orbit and motion.orbit is not None:
        time = _orbit_rows(histories)
        flown = along_orbit(motion.orbit, time)
        history = OrbitHistory(start, time, flown.position, flown.velocity)
        contents[f"{motion.name}.oem"] = oem_text(history, named)
        words[f"{motion.name}.oem"] = f"{len(time)} states, EME2000"
    with filling(folder) as partial:
        for file, text in contents.items():
            (partial / file).write_text(text, encoding="utf-8")
    return [Exported(Path(folder) / file, words[file]) for file in contents]


def _text(form: Format, histories: list[AttitudeHistory], named: Named) -> str:
    if form is Format.aem_xml:
        return aem_xml(histories, named)
    if form in (Format.aem, Format.aem_1):
        return aem_text(histories, named, 1 if form is Format.aem_1 else 2)
    return (stk_text if form is Format.stk else csv_text)(_as_one(histories))


def _as_one(histories: list[AttitudeHistory]) -> AttitudeHistory:
    """All spans as one; where two meet in an instant, the later one's attitude there."""
    kept = [
        h.time < (n.time[0] if n is not None else math.inf)
        for h, n in zip(histories, [*histories[1:], None], strict=True)
    ]
    return AttitudeHistory(
        histories[0].epoch,
        *(
            np.concatenate([getattr(h, part)[k] for h, k in zip(histories, kept, strict=True)])
            for part in ("time", "q_ib", "omega_ib")
        ),
    )


def _rows(path: AttitudePath, step: float | None) -> Floats:
    """Times of the rows: all of the path's own, and as many between each two as it takes."""
    lengths = np.diff(path.time)
    counts = np.full(len(lengths), _ROWS_AN_INTERVAL)
    if step is not None:
        counts = np.maximum(1, np.ceil(lengths / step - 1e-9)).astype(int)
    if counts.sum() > MOST_ROWS:
        raise ScenarioError(f"--step {step}: makes {counts.sum()} rows; give a longer one")
    parts = [
        t + length * np.arange(count) / count
        for t, length, count in zip(path.time[:-1], lengths, counts, strict=True)
    ]
    return np.concatenate([*parts, path.time[-1:]])


def _orbit_rows(histories: list[AttitudeHistory]) -> Floats:
    first, last = histories[0].time[0], histories[-1].time[-1]
    count = max(_ORBIT_ROWS, math.ceil((last - first) / _ORBIT_STEP) + 1)
    return np.linspace(first, last, count)


def _span(histories: list[AttitudeHistory]) -> str:
    moments = [
        history.epoch + dt.timedelta(seconds=float(time))
        for history, time in (
            (histories[0], histories[0].time[0]),
            (histories[-1], histories[-1].time[-1]),
        )
    ]
    return " to ".join(f"{m:%Y-%m-%dT%H:%M:%S}.{m.microsecond // 1000:03d}Z" for m in moments)
