"""Map of the best answers to targets all over SO(3): labelled, printed, drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.turns import turns_figure
from jaxatt.report.store.dataset import load_store
from jaxatt.report.store.layout import DONE
from jaxatt.report.store.names import store_name
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.attitude_map.run import run_map
from jaxatt.studies.attitude_map.study import REACHED_COLUMN, MapStudy, map_study
from jaxatt.studies.attitude_map.table import map_numbers, map_table
from jaxatt.studies.stored_study import StoredStudy

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


class AttitudeMap(StoredStudy):
    """Best answers to targets all over SO(3), all or those that are done so far.

    dataset : one dimension, "sample", with `q_ob`, `turn_axis` and `turn_deg` as coordinates.
    """

    @property
    def mapped(self) -> tuple[str, ...]:
        """Names of what is mapped."""
        return tuple(self.dataset.attrs["mapped"].split())

    @property
    def reached(self) -> bool:
        """Whether all targets that are done are reached."""
        done = self.dataset[DONE].values
        return bool(self.dataset[REACHED_COLUMN].values[done].all())

    @property
    def missed(self) -> int:
        """Number of targets that are done and not reached."""
        return int((self.dataset[DONE] & ~self.dataset[REACHED_COLUMN]).sum())

    def table(self) -> Group:
        """Range of what is mapped, and the worst errors."""
        return map_table(self.dataset, self.mapped)

    def plot(self, name: str | None = None) -> Picture:
        """Draw what is mapped, or another column, over the axis and the angle of the turn."""
        name = name or self.mapped[0]
        data, done = self.dataset, self.dataset[DONE].values
        return turns_figure(
            data["turn_axis"].values[done],
            np.radians(data["turn_deg"].values[done]),
            data[name].values[done],
            data[REACHED_COLUMN].values[done],
            name,
            data.attrs["title"],
        )

    def save(self, folder: str | Path) -> list[Path]:
        """Write map.json and a figure of everything that is mapped; return the files."""
        names = ["map.json", *(f"map-{name}.png" for name in self.mapped)]
        with filling(folder) as partial:
            write_json(map_numbers(self.dataset, self.mapped), partial / names[0])
            for name in self.mapped:
                save_figure(self.plot(name), partial / f"map-{name}.png")
        return [Path(folder) / name for name in names]

    def __repr__(self) -> str:
        done = self.dataset[DONE].values
        reached = int(self.dataset[REACHED_COLUMN].values.sum())
        return f"AttitudeMap({self.path}: {done.sum()} of {done.size} targets, {reached} reached)"


def attitude_map(
    scenario: scenarios.Scenario | str | Path,
    targets: int = 1000,
    path: str | Path | None = None,
    *,
    objective: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    share: tuple[int, int] = (0, 1),
    report: Report | None = None,
) -> AttitudeMap:
    """Find the best answer of a scenario to targets all over SO(3), each flown again.

    scenario : a `Scenario`, the name of a bundled one or a TOML file, with one target, which the
    map's take the place of.  targets : how many, spread evenly over all turns from the initial
    attitude.  path : the store, a folder; NAME-map.zarr by default.
    objective, starts, seed : replace the scenario's own settings; starts are those of each target.
    share : task i of n of a job array.
    report : called by the host with (stage, targets that have just ended).

    Raises `ScenarioError` where the scenario has no target to turn, and `OutputError` where the
    store is of another map or cannot be written.
    """
    study = map_study(scenario, targets, objective, starts, seed)
    return solve_map(study, store_name(study.name, share) if path is None else path, share, report)


def solve_map(
    study: MapStudy, path: str | Path, share: tuple[int, int] = (0, 1), report: Report | None = None
) -> AttitudeMap:
    """Answer the targets of a checked study that the store at `path` does not hold yet."""
    run_map(study, path, share, report)
    return AttitudeMap(Path(path), load_store(path))
