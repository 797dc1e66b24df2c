"""Write all files of a simulation into one folder."""

from __future__ import annotations

from pathlib import Path

from jaxatt.drawing.figure import save
from jaxatt.report.flight_dataset import flight_dataset
from jaxatt.report.flight_plots import overview, phase_portrait
from jaxatt.report.flight_record import FlightRecord
from jaxatt.report.flight_summary import flight_summary
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json


def save_flight(result: FlightRecord, folder: str | Path) -> list[Path]:
    """Write summary, archive and figures; either all of them appear, or none."""
    with filling(folder) as partial:
        write_json(flight_summary(result), partial / "summary.json")
        flight_dataset(result).to_netcdf(partial / "flight.nc", engine="h5netcdf")
        save(overview(result), partial / "overview.png")
        save(phase_portrait(result), partial / "phase_portrait.png")
        names = sorted(entry.name for entry in partial.iterdir() if entry.is_file())
    return [Path(folder) / name for name in names]
