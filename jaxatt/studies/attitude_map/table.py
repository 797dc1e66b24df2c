"""Table and numbers of a map: the range of what is mapped, and how good the answers are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.pipeline.solve_targets import CHECKED
from jaxatt.records.wording import short
from jaxatt.report.store.layout import DONE
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.attitude_map.study import REACHED_COLUMN

if TYPE_CHECKING:
    import xarray


def _values(dataset: xarray.Dataset, name: str) -> Floats:
    """Values of the targets that are reached; NaN elsewhere."""
    return np.where(dataset[REACHED_COLUMN].values, dataset[name].values, np.nan)


def _turn(dataset: xarray.Dataset, sample: int) -> str:
    axis = ", ".join(f"{x:.2f}" for x in dataset["turn_axis"].values[sample])
    return f"{float(dataset['turn_deg'][sample]):.1f} deg about ({axis})"


def map_table(dataset: xarray.Dataset, mapped: Sequence[str]) -> Group:
    """Range of what is mapped over the targets that are reached, and the worst errors of all."""
    table = Table(title=dataset.attrs["title"], title_justify="left")
    table.add_column("")
    for name in ("least", "at a turn of", "median", "greatest", "at a turn of"):
        table.add_column(name, justify="left" if name.startswith("at") else "right")
    for name in mapped:
        values = _values(dataset, name)
        if np.isnan(values).all():
            table.add_row(name, "-", "", "-", "-", "")
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        same = values[low] == values[high]
        table.add_row(
            name,
            short(float(values[low]), 6),
            "" if same else _turn(dataset, low),
            short(float(np.nanmedian(values)), 6),
            short(float(values[high]), 6),
            "" if same else _turn(dataset, high),
        )
    return Group(table, *(Text(sentence) for sentence in _sentences(dataset)))


def _sentences(dataset: xarray.Dataset) -> tuple[str, ...]:
    done, reached = dataset[DONE].values, dataset[REACHED_COLUMN].values
    worst = {name: _values(dataset, name) for name in CHECKED}
    told = [
        f"{name} {np.nanmax(values):.2g}"
        for name, values in worst.items()
        if np.isfinite(values).any()
    ]
    found = [f"{done.sum()} of {done.size} targets done, {reached.sum()} reached when flown."]
    if told:
        found.append(f"Worst of those: {', '.join(told)}.")
    lost = np.flatnonzero(done & ~reached)
    if len(lost):
        found.append(f"{len(lost)} are not reached; the first is {_turn(dataset, int(lost[0]))}.")
    return tuple(found)


def map_numbers(dataset: xarray.Dataset, mapped: Sequence[str]) -> dict[str, Any]:
    """The same as plain numbers, for a file."""
    numbers: dict[str, Any] = {
        "scenario": dataset.attrs["scenario"],
        "targets": int(dataset[DONE].size),
        "done": int(dataset[DONE].sum()),
        "reached": int(dataset[REACHED_COLUMN].sum()),
    }
    for name in mapped:
        values = _values(dataset, name)
        known = values[np.isfinite(values)]
        ranks = dict(zip(("least", "median", "greatest"), (0.0, 0.5, 1.0), strict=True))
        numbers[name] = {
            word: float(np.quantile(known, rank)) if len(known) else None
            for word, rank in ranks.items()
        }
    for name in CHECKED:
        known = _values(dataset, name)
        known = known[np.isfinite(known)]
        numbers[f"worst_{name}"] = float(known.max()) if len(known) else None
    return numbers
