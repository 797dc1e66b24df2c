"""The folder in which programs that were compiled are kept for the next process.

What lies there is run as it is, so a folder that others may write into is not used.
"""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import shutil
import stat
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import platformdirs

MOST_BYTES = 1 << 30
"""What the folder of the user may hold."""


class Kept(NamedTuple):
    """What a cache holds: number of files and their bytes."""

    files: int
    size: int


def user_cache() -> Path:
    """The user's own folder, for all machines."""
    return platformdirs.user_cache_path("jaxatt", appauthor=False) / "compiled"


@functools.cache
def machine() -> str:
    """Digest of this processor and this version of JAX.

    Programs for other processors may end a process, and home folders are shared by machines.
    """
    words = [platform.machine(), version("jax"), version("jaxlib")]
    with suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as lines:
        words.append(next((line for line in lines if line.startswith(("flags", "Features"))), ""))
    return hashlib.sha256(" ".join(words).encode()).hexdigest()[:16]


def machine_cache() -> Path:
    """The part of the user's folder for this processor and this version of JAX."""
    return user_cache() / machine()


def make_private(folder: Path) -> str:
    """Make a folder that only this user may write into, if it is missing.

    Returns a sentence on why it cannot be used, or an empty text.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.stat()
    except (OSError, ValueError) as error:
        return f"{folder}: cannot be used to keep compiled programs ({error})"
    if not hasattr(os, "getuid"):
        return ""
    if found.st_uid != os.getuid():
        return f"{folder}: belongs to another user, so nothing in it is run; name another folder"
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return (
            f"{folder}: others may write into it, so nothing in it is run; "
            f"chmod 700 {folder}, or name another folder"
        )
    return ""


def kept(folder: Path) -> Kept:
    """What a folder holds."""
    sizes = [size for _, size, _ in _entries(folder)]
    return Kept(len(sizes), sum(sizes))


def clear(folder: Path) -> Kept:
    """Remove a folder; return what it held."""
    held = kept(folder)
    shutil.rmtree(folder, ignore_errors=True)
    return held


def trim(folder: Path, most: int = MOST_BYTES) -> None:
    """Remove the files that were used longest ago, until a folder holds at most so many bytes."""
    entries = sorted(_entries(folder))
    total = sum(size for _, size, _ in entries)
    for _, size, path in entries:
        if total <= most:
            return
        with suppress(OSError):
            path.unlink()
            total -= size


def _entries(folder: Path) -> list[tuple[float, int, Path]]:
    """Time of the last use, size and path of every file."""
    found = []
    for path in folder.rglob("*"):
        with suppress(OSError):
            state = path.stat()
            if stat.S_ISREG(state.st_mode):
                found.append((max(state.st_atime, state.st_mtime), state.st_size, path))
    return found
