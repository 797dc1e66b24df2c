"""Whether a store holds the samples that are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.report.store.layout import Layout
from jaxatt.runtime.files import OutputError


def check_same(path: Path, found: Layout, asked: Layout) -> None:
    """Refuse a store that does not hold the samples of `asked`, with `OutputError`."""
    other = "name another folder, or remove this one to begin again"
    for name in {**asked.identity, **found.identity}:
        has, wants = found.identity.get(name), asked.identity.get(name)
        if name == "contents" and has != wants:
            raise OutputError(
                f"{path}: holds samples of other values, or of a scenario that was another then; "
                f"{other}"
            )
        if has != wants:
            raise OutputError(f"{path}: holds {name} {has}, not {wants}; {other}")
    if (found.samples, found.chunk) != (asked.samples, asked.chunk):
        raise OutputError(
            f"{path}: holds {found.samples} samples in chunks of {found.chunk}, not "
            f"{asked.samples} in chunks of {asked.chunk}; {other}"
        )
    if dict(found.columns) != dict(asked.columns):
        differ = sorted(
            name
            for name in {*found.columns, *asked.columns}
            if found.columns.get(name) != asked.columns.get(name)
        )
        raise OutputError(f"{path}: has other columns ({', '.join(differ)}); {other}")
    for name in {**found.coordinates, **asked.coordinates}:
        if not _equal(found.coordinates.get(name), asked.coordinates.get(name)):
            raise OutputError(f"{path}: its coordinates {name} are others; {other}")


def _equal(one: Any, other: Any) -> bool:
    return one is not None and other is not None and np.array_equal(one[1], other[1])
