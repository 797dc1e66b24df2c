"""A store's description as zarr keeps it: create, open, read back."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.report.store.layout import DONE, SAMPLE, STRING, Column, Layout
from jaxatt.runtime.files import OutputError

FORMAT = "1"
_FORMAT, _IDENTITY, _COORDINATES = "jaxatt_store", "identity", "coordinates"
_EMPTY = {"float64": np.nan, STRING: ""}


def create(path: Path, layout: Layout) -> None:
    """Write an empty store with all its coordinates."""
    import zarr

    group = zarr.create_group(
        path,
        zarr_format=3,
        attributes={
            **layout.attributes,
            _FORMAT: FORMAT,
            _IDENTITY: json.dumps(dict(layout.identity)),
            _COORDINATES: " ".join(layout.coordinates),
        },
    )
    for name, (dims, values, attributes) in layout.coordinates.items():
        data = np.asarray(values)
        text = data.dtype.kind in "UTO"
        array = group.create_array(
            name,
            shape=data.shape,
            dtype=str if text else data.dtype,
            dimension_names=tuple(dims),
            attributes=dict(attributes),
        )
        array[...] = data.astype(object) if text else data
    for name, column in {**layout.columns, DONE: Column("bool")}.items():
        group.create_array(
            name,
            shape=(layout.samples, *column.shape),
            chunks=(layout.chunk, *column.shape),
            dtype=str if column.dtype == STRING else column.dtype,
            fill_value=_EMPTY.get(column.dtype, 0),
            dimension_names=(SAMPLE, *column.dims),
            attributes=dict(column.attributes),
        )
    with warnings.catch_warnings():
        # Not yet in the specification of zarr 3; without it xarray reads the same, more slowly.
        warnings.filterwarnings("ignore", "Consolidated metadata", UserWarning)
        zarr.consolidate_metadata(path, zarr_format=3)


def opened(path: Path, mode: str) -> Any:
    """Open a store; raises `OutputError` where the folder is none, or one of another version."""
    import zarr

    if (path / "summary.json").is_file():
        raise OutputError(
            f"{path}: holds a result and no store of samples; look at its figures and "
            "summary.json, or read its archive with jaxatt.open_archive"
        )
    try:
        group: Any = zarr.open_group(path, mode=mode, zarr_format=3)  # type: ignore[arg-type]
    except (OSError, ValueError, KeyError, TypeError) as error:
        inside = sorted(path.glob("*.zarr"))
        mend = f"name {inside[0]}" if inside else "check the path"
        why = "" if isinstance(error, FileNotFoundError) else f" ({error})"
        raise OutputError(f"{path}: is no store of samples{why}; {mend}") from None
    version = group.attrs.get(_FORMAT)
    if version != FORMAT:
        has = "no store of samples" if version is None else f"a store of version {version}"
        raise OutputError(
            f"{path}: is {has}, where version {FORMAT} is read and written; name another folder"
        )
    return group


def layout_of(path: Path) -> Layout:
    """Read back what a store holds."""
    group = opened(path, "r")
    attributes = dict(group.attrs)
    attributes.pop(_FORMAT)
    identity = json.loads(attributes.pop(_IDENTITY))
    named = attributes.pop(_COORDINATES).split(" ")
    arrays = dict(group.arrays())
    done = arrays.pop(DONE)
    coordinates = {name: arrays.pop(name) for name in named if name}
    return Layout(
        done.shape[0],
        done.chunks[0],
        identity,
        {
            name: (tuple(a.metadata.dimension_names), np.asarray(a[...]), dict(a.attrs))
            for name, a in coordinates.items()
        },
        {
            name: Column(
                STRING if a.dtype.kind == "T" else str(a.dtype),
                tuple(a.metadata.dimension_names[1:]),
                tuple(a.shape[1:]),
                dict(a.attrs),
            )
            for name, a in arrays.items()
        },
        attributes,
    )
