"""Open a store as a labelled xarray Dataset, while it grows too."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from jaxatt.report.store.store import read_layout

if TYPE_CHECKING:
    import xarray


def open_store(path: str | Path) -> xarray.Dataset:
    """Open a store without reading its columns; samples not yet written are not `done`.

    Raises `OutputError` where the folder is no store.
    """
    import xarray

    read_layout(path)
    return xarray.open_zarr(str(path), chunks=None)


def load_store(path: str | Path) -> xarray.Dataset:
    """Read all of a store; raises `OutputError` as `open_store`."""
    with open_store(path) as opened:
        return opened.load()
