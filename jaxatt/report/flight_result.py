"""Result of a simulation, which prints, draws and saves itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.report.flight_dataset import flight_dataset
from jaxatt.report.flight_folder import save_flight
from jaxatt.report.flight_plots import overview
from jaxatt.report.flight_record import FlightRecord
from jaxatt.report.flight_summary import flight_summary
from jaxatt.report.flight_table import flight_table

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class FlightResult(FlightRecord):
    """A simulation that prints, draws and saves itself; the fields are those of `FlightRecord`."""

    def summary(self) -> dict[str, Any]:
        """Return plain numbers under stable names, ready for JSON."""
        return flight_summary(self)

    def to_dataset(self) -> xarray.Dataset:
        """Return labelled arrays in SI units and radians, with settings as attributes."""
        return flight_dataset(self)

    def plot(self) -> Figure:
        """Plot errors, rates, torques and wheel speeds, as bands where there are many runs."""
        return overview(self)

    def save(self, folder: str | Path) -> list[Path]:
        """Write summary.json, flight.nc and the figures into a folder; return the files."""
        return save_flight(self, folder)

    def __str__(self) -> str:
        return as_text(flight_table(self))

    def _repr_html_(self) -> str:
        return as_html(flight_table(self))
