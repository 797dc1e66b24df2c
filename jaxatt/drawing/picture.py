"""A figure as notebooks show it."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

DPI = 150


class Picture(Figure):
    """A figure that a notebook shows without further settings."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=DPI)
        return buffer.getvalue()
