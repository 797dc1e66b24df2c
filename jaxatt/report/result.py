"""Result of a solve, which prints, draws and saves itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.problems.answer import Answer
from jaxatt.report.dataset import to_dataset
from jaxatt.report.folder import save
from jaxatt.report.plots import plot
from jaxatt.report.summary import summary
from jaxatt.report.tables import result_table

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Result(Answer):
    """An answer that prints, draws and saves itself; the fields are those of `Answer`."""

    def summary(self) -> dict[str, Any]:
        """Return plain numbers under stable names, ready for JSON."""
        return summary(self)

    def to_dataset(self) -> xarray.Dataset:
        """Return labelled arrays in SI units and radians, with settings as attributes."""
        return to_dataset(self)

    def plot(self) -> Figure:
        """Plot the overview: every quantity over time, and the outcome of all starts."""
        return plot(self)

    def save(self, folder: str | Path, figures: str = "all") -> list[Path]:
        """Write summary.json, result.nc and figures into a folder; return the files.

        figures : "all", "overview" or "none".
        Raises `OutputError` (a `ValueError`) where nothing can be written.
        """
        return save(self, folder, figures)

    def __str__(self) -> str:
        return as_text(result_table(self))

    def _repr_html_(self) -> str:
        return as_html(result_table(self))
