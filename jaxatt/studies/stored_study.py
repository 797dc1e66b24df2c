"""What the results of all studies that grow a store have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Group

from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.report.store.layout import DONE

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class StoredStudy(ABC):
    """Samples of a study, all or those that are done so far.

    path : of the store.  dataset : one dimension, "sample"; NaN where a sample is not done.
    """

    path: Path
    dataset: xarray.Dataset

    @property
    def complete(self) -> bool:
        """Whether all samples are done."""
        return bool(self.dataset[DONE].all())

    @property
    @abstractmethod
    def reached(self) -> bool:
        """Whether all samples that are done reached their target."""

    @abstractmethod
    def table(self) -> Group:
        """Return a table of what the store holds."""

    @abstractmethod
    def save(self, folder: str | Path) -> list[Path]:
        """Write figures and tables into a folder; return the files."""

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())
