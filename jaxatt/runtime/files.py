"""Output folders that are checked before the work, and files that are written completely or not."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


class OutputError(ValueError):
    """An output folder that cannot be written: the message names it and says how to mend it."""


def prepare_folder(path: str | Path) -> Path:
    """Check that files can be written into a folder, and leave no trace of the check.

    Raises
    ------
    OutputError
        The folder can be neither made nor written into.
    """
    folder = Path(path)
    missing = [part for part in (folder, *folder.parents) if not os.path.exists(part)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:  # a ValueError for what no path can hold
        reason = getattr(error, "strerror", None) or error
        raise OutputError(
            f"{folder}: nothing can be written there ({reason}); name another folder or change its "
            "permissions"
        ) from error
    finally:
        for part in missing:
            with suppress(OSError):
                part.rmdir()
    return folder


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`, and rename it to `path` on success."""
    path = Path(path)
    partial = path.with_name(f".{path.stem}-{os.getpid()}{path.suffix}")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def filling(path: str | Path) -> Iterator[Path]:
    """Give a temporary folder in `path`, and move its files into `path` on success."""
    folder = prepare_folder(path)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".partial-", dir=folder) as partial:
        yield Path(partial)
        for entry in sorted(Path(partial).iterdir()):
            os.replace(entry, folder / entry.name)
