"""Write the flown motion of a saved result for other tools."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

from jaxatt.environment import epoch as calendar
from jaxatt.exchange.motion import Named
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.export.files import Exported, Format, write_files
from jaxatt.report.export.saved_motion import saved_motion


def export(
    result: str | Path,
    folder: str | Path | None = None,
    *,
    form: str = Format.aem,
    epoch: str | dt.datetime | None = None,
    step: float | None = None,
    orbit: bool = False,
    run: int = 0,
    name: str | None = None,
    designator: str = "UNKNOWN",
) -> list[Exported]:
    """Write the attitude of a saved result, from EME2000 to body, and its orbit if asked.

    result : folder of a solve, plan or simulation, or its archive.
    folder : for the files; by default the result's.
    form : "aem", "aem-xml" (CCSDS AEM 2), "aem-1" (AEM 1), "stk" or "csv".
    epoch : UTC of the scenario's start, in place of its own.
    step : longest time [s] between two rows; a tenth of the result's own by default.
    orbit : the orbit, too, as a CCSDS OEM.  run : of a campaign.
    name, designator : of the spacecraft, in CCSDS files; the scenario's name by default.

    Raises `ScenarioError` where the result cannot be used, or has no epoch or orbit that is asked
    for.
    """
    for text in (name, designator):
        if text is not None and not (text.isascii() and text.isprintable() and text.strip()):
            raise ScenarioError(f"{text!r}: is no name for CCSDS files; give one line of ASCII")
    place = Path(result)
    motion = saved_motion(place, run)
    return write_files(
        motion,
        folder or (place if place.is_dir() else place.parent),
        Format(form),
        epoch=_moment(epoch) if isinstance(epoch, str) else epoch,
        step=step,
        orbit=orbit,
        named=Named(name or motion.name, designator),
    )


def _moment(text: str) -> dt.datetime:
    try:
        return calendar.parse(text)
    except (ValueError, OverflowError):
        raise ScenarioError(
            f"epoch {text}: is no moment; write it as 2026-06-21T12:00:00Z"
        ) from None
