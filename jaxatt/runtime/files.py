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
        raise _refused(folder, error) from error
    finally:
        for part in missing:
            with suppress(OSError, ValueError):
                part.rmdir()
    return folder


def _refused(folder: Path, error: Exception) -> OutputError:
    is_file = isinstance(error, FileExistsError)
    reason = "it is a file" if is_file else getattr(error, "strerror", None) or error
    return OutputError(
        f"{folder}: nothing can be written there ({reason}); name another folder, make room in it "
        "or change its permissions"
    )


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
    """Give a temporary folder in `path`, and move its files into `path` on success.

    Raises `OutputError` where something cannot be written, such as on a full disk.
    """
    folder = prepare_folder(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".partial-", dir=folder) as partial:
            yield Path(partial)
            for entry in sorted(Path(partial).iterdir()):
                os.replace(entry, folder / entry.name)
    except OSError as error:
        raise _refused(folder, error) from error
