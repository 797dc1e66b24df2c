"""Write and read results as netCDF files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from jaxatt.problems.answer import Answer
from jaxatt.report.dataset import to_dataset
from jaxatt.runtime.files import OutputError, replacing

if TYPE_CHECKING:
    import xarray

ARCHIVES = ("result.nc", "flight.nc")
"""Archives that the folder of a result may hold."""


def write_archive(result: Answer, path: str | Path) -> None:
    """Write `to_dataset(result)` as a netCDF file, completely or not at all."""
    with replacing(path) as partial:
        to_dataset(result).to_netcdf(partial, engine="h5netcdf")


def open_archive(path: str | Path) -> xarray.Dataset:
    """Read an archive, or that of a result's folder, into memory, and close the file."""
    import xarray

    path = Path(path)
    inside = (path / name for name in ARCHIVES)
    path = next((each for each in inside if each.is_file()), path)
    if not path.is_file():
        raise OutputError(
            f"{path}: is no archive; give result.nc, flight.nc, or the folder that holds one"
        )
    return xarray.load_dataset(path, engine="h5netcdf")
