"""Write all files of a result into one folder."""

from __future__ import annotations

from pathlib import Path

from jaxatt.problems.answer import Answer
from jaxatt.report.archive import write_archive
from jaxatt.report.plots import save_figures
from jaxatt.report.summary import write_summary
from jaxatt.runtime.files import filling


def save(result: Answer, folder: str | Path) -> list[Path]:
    """Write summary, archive and figures; either all of them appear, or none."""
    with filling(folder) as partial:
        write_summary(result, partial / "summary.json")
        write_archive(result, partial / "result.nc")
        save_figures(result, partial)
        names = sorted(entry.name for entry in partial.iterdir() if entry.is_file())
    return [Path(folder) / name for name in names]
