"""Table of a sweep: where each output is least and greatest, and what failed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.records.wording import short
from jaxatt.report.store.layout import DONE
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, REASON, STATE

if TYPE_CHECKING:
    import xarray


def sweep_table(dataset: xarray.Dataset, names: Sequence[str], outputs: Sequence[str]) -> Group:
    """Range of every output over the samples that reached, and sentences on the others."""
    table = Table(title=dataset.attrs["title"], title_justify="left")
    table.add_column("output")
    for name in ("least", "at", "median", "greatest", "at"):
        table.add_column(name, justify="left" if name == "at" else "right")
    reached = dataset[STATE].values == REACHED
    for name in outputs:
        values = np.where(reached, dataset[name].values, np.nan)
        if np.isnan(values).all():
            table.add_row(name, "-", "", "-", "-", "")
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        table.add_row(
            name,
            short(float(values[low]), 6),
            where(dataset, names, low),
            short(float(np.nanmedian(values)), 6),
            short(float(values[high]), 6),
            where(dataset, names, high),
        )
    return Group(table, *(Text(sentence) for sentence in sentences(dataset, names)))


def sentences(dataset: xarray.Dataset, names: Sequence[str]) -> tuple[str, ...]:
    """How many samples are done, reached, and failed, with the first reason of each kind."""
    done, state = dataset[DONE].values, dataset[STATE].values
    found = [f"{done.sum()} of {done.size} samples done, {(state == REACHED).sum()} reached."]
    for kind, words in ((NOT_REACHED, "do not reach their target"), (FAILED, "have no answer")):
        which = np.flatnonzero(state == kind)
        if which.size:
            first = int(which[0])
            reason = str(dataset[REASON].values[first])
            found.append(
                f"{which.size} {words}; the first at {where(dataset, names, first)}: {reason}"
            )
    return tuple(found)


def where(dataset: xarray.Dataset, names: Sequence[str], sample: int) -> str:
    """Values of the swept quantities in one sample."""
    values = ((name, dataset[name].values[sample]) for name in names)
    return ", ".join(
        f"{name} = {value}" if isinstance(value, str) else f"{name} = {float(value):.5g}"
        for name, value in values
    )
