"""Merge the stores of several tasks of one study into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.report.store.agreement import check_same
from jaxatt.report.store.layout import DONE
from jaxatt.report.store.store import Store, read_layout
from jaxatt.report.store.zarr_files import opened
from jaxatt.runtime.files import OutputError


@dataclass(frozen=True)
class Merged:
    """A store that others were merged into, and how many of its samples are done."""

    path: Path
    done: int
    samples: int


def merge(paths: Sequence[str | Path], out: str | Path) -> Merged:
    """Copy all chunks that are done in any of the stores into one.

    Raises `OutputError` where the stores are of different studies or versions, their coordinates
    clash, or two of them hold other values of one sample.
    """
    sources = [Path(path) for path in paths]
    if not sources:
        raise OutputError("no stores to merge; name one or more")
    if Path(out).resolve() in {path.resolve() for path in sources}:
        raise OutputError(f"{out}: is merged itself; name another folder with --out")
    layout = read_layout(sources[0])
    for path in sources[1:]:
        check_same(path, read_layout(path), layout)
    with Store.open_or_create(out, layout) as store:
        for path in sources:
            _copy(path, store)
        return Merged(Path(out), int(store.done.sum()), layout.samples)


def _copy(path: Path, store: Store) -> None:
    source, target = opened(path, "r"), opened(store.path, "r")
    has, had, layout = np.asarray(source[DONE][:]), store.done, store.layout
    for chunk in range(layout.chunks):
        rows = layout.rows(chunk)
        if not has[rows].all():
            continue
        columns = {name: source[name][rows] for name in layout.columns}
        if not had[rows].all():
            store.write(chunk, columns)
            continue
        for name, values in columns.items():
            if not _same(values, target[name][rows]):
                raise OutputError(
                    f"{path}: {name} of samples {rows.start} to {rows.stop - 1} differs from what "
                    f"{store.path} holds already; merge the stores of one study only"
                )


def _same(one: Any, other: Any) -> bool:
    a, b = np.asarray(one), np.asarray(other)
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
