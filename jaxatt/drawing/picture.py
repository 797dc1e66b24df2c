"""A figure as notebooks show it."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_DPI = 150


class Picture(Figure):
    """A figure that a notebook shows without further settings."""

    def __init__(self, width: float, height: float) -> None:
        """Make an empty figure of a size in inches."""
        super().__init__(figsize=(width, height), dpi=_DPI, layout="constrained")

    def write_png(self, file: Any) -> None:
        """Write to a path or an open file; `savefig` does the same, but draws twice for it."""
        FigureCanvasAgg(self).print_png(file)  # type: ignore[no-untyped-call]

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.write_png(buffer)
        return buffer.getvalue()
