"""Write and read results as netCDF files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from jaxatt.problems.answer import Answer
from jaxatt.report.dataset import to_dataset
from jaxatt.runtime.files import replacing

if TYPE_CHECKING:
    import xarray


def write_archive(result: Answer, path: str | Path) -> None:
    """Write `to_dataset(result)` as a netCDF file, completely or not at all."""
    with replacing(path) as partial:
        to_dataset(result).to_netcdf(partial, engine="h5netcdf")


def open_archive(path: str | Path) -> xarray.Dataset:
    """Read an archive into memory, and close the file."""
    import xarray

    return xarray.load_dataset(path, engine="h5netcdf")
