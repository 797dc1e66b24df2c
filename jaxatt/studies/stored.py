"""Open the results that a store holds, whatever study made them."""

from __future__ import annotations

from pathlib import Path

from jaxatt.report.store.dataset import load_store
from jaxatt.runtime.files import OutputError
from jaxatt.studies.attitude_map.map import AttitudeMap
from jaxatt.studies.stored_study import StoredStudy
from jaxatt.studies.sweep.sweep import Sweep

_KINDS: dict[str, type[StoredStudy]] = {"map": AttitudeMap, "sweep": Sweep}


def open_study(path: str | Path) -> StoredStudy:
    """Read what a store holds so far; its own attribute `kind` says which study it is of.

    Raises `OutputError` where the folder is no store of a sweep or of a map.
    """
    found = load_store(path)
    kind = _KINDS.get(str(found.attrs.get("kind")))
    if kind is None:
        raise OutputError(f"{path}: is a store of neither a sweep nor a map; check the path")
    return kind(Path(path), found)
