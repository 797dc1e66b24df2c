"""Samples of a sweep as they are in its store: labelled, printed, drawn."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group

from jaxatt.drawing.figure import save as save_figure
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.store.dataset import load_store
from jaxatt.report.store.layout import DONE
from jaxatt.report.store.names import store_name
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.studies.stored_study import StoredStudy
from jaxatt.studies.sweep.figure import sweep_figure
from jaxatt.studies.sweep.reading import load_study, read_study
from jaxatt.studies.sweep.run import run_study
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, STATE, Study
from jaxatt.studies.sweep.table import sweep_table

if TYPE_CHECKING:
    import xarray

    from jaxatt.drawing.picture import Picture


class Sweep(StoredStudy):
    """Samples of a sweep, all or those that are done so far.

    dataset : one dimension, "sample", with the swept quantities as coordinates; outputs are NaN
    where a sample is not done or has no answer.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the swept quantities, "scenario" first where there are several."""
        return tuple(self.dataset.attrs["quantities"].split())

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(self.dataset.attrs["outputs"].split())

    @property
    def reached(self) -> bool:
        """Whether all samples that are done reached their target."""
        done = self.dataset[DONE].values
        return bool((self.dataset[STATE].values[done] == REACHED).all())

    @property
    def failed(self) -> int:
        """Number of samples without an answer."""
        return int((self.dataset[STATE].values == FAILED).sum())

    @property
    def missed(self) -> int:
        """Number of samples whose answer does not reach its target."""
        return int((self.dataset[STATE].values == NOT_REACHED).sum())

    def grid(self) -> xarray.Dataset:
        """The samples of a grid with one dimension a quantity.

        Raises `ScenarioError` where they are no grid.
        """
        names, method = self.names, self.dataset.attrs["method"]
        if method != "grid":
            raise ScenarioError(f'{self.path}: method = "{method}" makes no grid; use the dataset')
        if len(names) == 1:
            return self.dataset.swap_dims({"sample": names[0]})
        return self.dataset.set_index(sample=names).unstack("sample")

    def table(self) -> Group:
        """Return a table with one row an output."""
        return sweep_table(self.dataset, self.names, self.outputs)

    def plot(self) -> Picture:
        """Plot each output over the swept quantities."""
        against = self.dataset.attrs["against"].split()
        return sweep_figure(self.dataset, self.names, self.outputs, against)

    def save(self, folder: str | Path) -> list[Path]:
        """Write sweep.png into a folder; return the file."""
        with filling(folder) as partial:
            save_figure(self.plot(), partial / "sweep.png")
        return [Path(folder) / "sweep.png"]

    def __repr__(self) -> str:
        done = np.asarray(self.dataset[DONE].values)
        reached = int((self.dataset[STATE].values == REACHED).sum())
        return f"Sweep({self.path}: {done.sum()} of {done.size} samples, {reached} reached)"


def sweep(
    study: Study | Mapping[str, Any] | str | Path,
    path: str | Path | None = None,
    *,
    share: tuple[int, int] = (0, 1),
    report: Report | None = None,
) -> Sweep:
    """Solve the samples of a study that its store does not hold yet.

    study : a bundled study's name, a TOML file, or a mapping with the names of such a file.
    path : the store, a folder; NAME.zarr by default, or NAME.task-i-of-n.zarr for a task.
    share : task i of n of a job array, which solves every n-th chunk.
    report : called by the host with (stage, samples that have just ended).

    Raises `ScenarioError` where the study does not make sense, and `OutputError` where the store is
    of another study or cannot be written.
    """
    if isinstance(study, Mapping):
        study = read_study(study)
    elif not isinstance(study, Study):
        study = load_study(study)
    path = Path(store_name(study.name, share) if path is None else path)
    run_study(study, path, share, report)
    return Sweep(path, load_store(path))
