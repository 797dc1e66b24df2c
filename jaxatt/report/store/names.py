"""Name of the store of a whole study, or of one task of a job array."""

from __future__ import annotations


def store_name(name: str, share: tuple[int, int] = (0, 1)) -> str:
    """Name of the folder; share : task i of n."""
    return f"{name}.zarr" if share == (0, 1) else f"{name}.task-{share[0]}-of-{share[1]}.zarr"
