"""Labelled store of samples that grows chunk by chunk, in zarr.

A chunk of every column is a file of its own, which is written beside its place and renamed, and the
column `done` is written last: a process killed at any moment leaves whole chunks, and what is not
`done` is computed again.  The store's description is complete from the beginning, so that xarray
opens it while it grows; what is still missing reads as NaN, 0 or "".
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from jaxatt.report.store.agreement import check_same
from jaxatt.report.store.layout import DONE, STRING, Layout
from jaxatt.report.store.zarr_files import create, layout_of, opened
from jaxatt.runtime.files import OutputError, prepare_folder

try:
    import fcntl
except ImportError:  # no locks on Windows
    fcntl = None  # type: ignore[assignment]


class Store:
    """A store opened for writing by this process alone; use it as a context.

    path : the folder.  layout : what it holds.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self.path, self.layout = path, layout
        self._group: Any = None
        self._lock = -1

    @classmethod
    def open_or_create(cls, path: str | Path, layout: Layout) -> Store:
        """Open a store of this layout, or make an empty one.

        Raises `OutputError` where the folder is no store, belongs to another study or version, is
        larger than the disk, is being written by another process, or cannot be written.
        """
        path = Path(path)
        if os.path.lexists(path):
            check_same(path, read_layout(path), layout)
        else:
            _make(path, layout)
        return cls(path, layout)

    def __enter__(self) -> Store:
        self._lock = _locked(self.path)
        try:
            with writing(self.path):
                for left in self.path.glob("*/**/*.partial"):
                    left.unlink(missing_ok=True)  # of a process that was killed
            self._group = opened(self.path, "r+")
        except BaseException:
            os.close(self._lock)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._lock)

    @property
    def done(self) -> np.ndarray:
        """Which samples are written, (S,) bool."""
        return np.asarray(self._group[DONE][:], bool)

    @property
    def complete(self) -> bool:
        """Whether all samples are written."""
        return bool(self.done.all())

    def pending(self, share: tuple[int, int] = (0, 1)) -> list[int]:
        """Chunks that are not written, of those of task i of n = `share`."""
        done = self.done
        return [k for k in self.layout.chunks_of(share) if not done[self.layout.rows(k)].all()]

    def written(self, share: tuple[int, int] = (0, 1)) -> int:
        """Number of samples that are written, of those of task i of n = `share`."""
        done = self.done
        return int(sum(done[self.layout.rows(k)].sum() for k in self.layout.chunks_of(share)))

    def write(self, chunk: int, columns: Mapping[str, Any]) -> None:
        """Write one chunk of every column, each (samples of the chunk, ...), and mark it done."""
        rows = self.layout.rows(chunk)
        missing = set(self.layout.columns) ^ set(columns)
        if missing:
            raise KeyError(f"columns of the chunk and of the store differ in {sorted(missing)}")
        with writing(self.path):
            for name, values in columns.items():
                column = self.layout.columns[name]
                dtype = object if column.dtype == STRING else column.dtype
                told = np.asarray(values, dtype)
                shape = (rows.stop - rows.start, *column.shape)
                if told.shape != shape:
                    raise ValueError(f"{name}: has shape {told.shape} in place of {shape}")
                self._group[name][rows] = told
            self._group[DONE][rows] = True


def read_layout(path: str | Path) -> Layout:
    """Layout of a store; raises `OutputError` where the folder is none."""
    path = Path(path)
    if not path.exists():
        raise OutputError(f"{path}: there is no such store; check the path")
    return layout_of(path)


def _make(path: Path, layout: Layout) -> None:
    """Make an empty store beside its place and rename it."""
    parent = prepare_folder(path.parent)
    there = next(p for p in (parent, *parent.resolve().parents) if p.exists())
    free = shutil.disk_usage(there).free
    if layout.bytes > free:
        raise OutputError(
            f"{path}: {layout.samples} samples may take {layout.bytes / 1e9:.3g} GB, and the disk "
            f"has {free / 1e9:.3g} GB left; take fewer samples or outputs, or another disk"
        )
    with writing(path):
        parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=parent) as beside:
            create(Path(beside) / path.name, layout)
            os.rename(Path(beside) / path.name, path)


def _locked(path: Path) -> int:
    """Lock of the folder until the process ends or the number that is returned is closed."""
    with writing(path):
        lock = os.open(path, os.O_RDONLY) if fcntl is not None else os.open(os.devnull, os.O_RDONLY)
    if fcntl is not None:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            raise OutputError(
                f"{path}: another process is writing it; wait for it, or give each a --task of "
                "its own"
            ) from None
        except OSError:
            pass  # a file system without locks
    return lock


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the system refuses into an `OutputError`."""
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be written ({error.strerror or error}); make room there or change its "
            "permissions, and start again: what is written stays"
        ) from error
