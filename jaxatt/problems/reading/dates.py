"""The epoch of a file, and the dates between which the models that need it hold."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass

from jaxatt.environment import epoch, igrf, sun
from jaxatt.problems.reading.fields import Table

_WRITTEN = "%Y-%m-%dT%H:%M:%SZ"
_ROUNDING = 1e-9  # days; an epoch is kept as a number of days


@dataclass(frozen=True)
class DatedModel:
    """A model that holds between two dates, in days since J2000; both included."""

    name: str
    first: float
    last: float

    def holds(self, days: float) -> bool:
        """Whether it holds on a date."""
        return self.first - _ROUNDING <= days <= self.last + _ROUNDING

    @property
    def span(self) -> str:
        """The two dates, as text."""
        return f"{moment_of(self.first):%Y-%m-%d} to {moment_of(self.last):%Y-%m-%d}"


def _between(name: str, first: float, last: float) -> DatedModel:
    starts = (dt.datetime(int(year), 1, 1, tzinfo=dt.UTC) for year in (first, last))
    return DatedModel(name, *map(epoch.days_since_j2000, starts))


MAGNETIC_FIELD = _between("the magnetic field of IGRF-14", igrf.FIRST_YEAR, igrf.LAST_YEAR)
SUNLIGHT = _between("the sun's direction", sun.FIRST_YEAR, sun.LAST_YEAR)
_ANY = _between("the orientation of the Earth", 1800, 2200)


def moment_of(days: float) -> dt.datetime:
    """Moment of an epoch, days since J2000."""
    return epoch.J2000 + dt.timedelta(days=days)


def beyond(model: DatedModel, days: float, duration: float) -> str:
    """Words on a motion that leaves the dates of a model; empty where it does not.

    days : since J2000.  duration : [s] from then on.
    """
    end = days + duration / epoch.SECONDS_PER_DAY
    if model.holds(days) and model.holds(end):
        return ""
    if model.holds(days):
        return f"the motion ends at {moment_of(end):{_WRITTEN}}, which is outside {model.span}"
    return f"epoch = {moment_of(days):{_WRITTEN}} is outside {model.span}"


def read_epoch(table: Table) -> float | None:
    """Read the epoch of a table, days since J2000; None without one.

    What needs the date asks for the dates of its model, see `check_epoch`.
    """
    if "epoch" not in table:
        return None
    try:
        days = epoch.days_since_j2000(epoch.parse(table.text("epoch")))
    except (ValueError, OverflowError) as error:
        if str(error).startswith(epoch.NO_LEAP_SECOND):
            table.fail("epoch", "has a second 60", epoch.NO_LEAP_SECOND)
        table.fail("epoch", "is no moment", 'write it as "2026-06-21T12:00:00Z"')
    check_epoch(table, days, 0.0, {_ANY: "any motion about the Earth"})
    return days


def check_epoch(
    table: Table, days: float | None, duration: float, needs: Mapping[DatedModel, str]
) -> None:
    """Refuse an epoch that is missing, or a motion that leaves the dates of a model it needs.

    days : since J2000.  duration : [s] from then on.  needs : model -> what needs it.
    Raises `ScenarioError`.
    """
    for model, need in needs.items():
        if days is None:
            table.fail(
                "epoch",
                f"missing, and {need} needs {model.name}, which depends on the date",
                'add a line such as epoch = "2026-06-21T12:00:00Z"',
            )
        end = days + duration / epoch.SECONDS_PER_DAY
        if model.holds(days) and model.holds(end):
            continue
        later = f"the motion ends at {moment_of(end):{_WRITTEN}}, which "
        table.fail(
            "epoch",
            f"{later if model.holds(days) else ''}is outside {model.span}; {need} needs "
            f"{model.name}, which is known between them",
            f"give a date within, or drop {need}",
        )
