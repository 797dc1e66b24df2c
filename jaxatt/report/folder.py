"""Write all files of a result into one folder."""

from __future__ import annotations

from pathlib import Path

from jaxatt.problems.answer import Answer
from jaxatt.report.archive import write_archive
from jaxatt.report.plots import Figures, save_figures
from jaxatt.report.summary import write_summary
from jaxatt.runtime.files import filling


def save(result: Answer, folder: str | Path, figures: Figures | str = Figures.all) -> list[Path]:
    """Write summary and archive, both or neither, then figures; return the files."""
    with filling(folder) as partial:
        write_summary(result, partial / "summary.json")
        write_archive(result, partial / "result.nc")
        names = sorted(entry.name for entry in partial.iterdir() if entry.is_file())
    drawn = save_figures(result, folder, figures)
    return sorted([*(Path(folder) / name for name in names), *drawn])
