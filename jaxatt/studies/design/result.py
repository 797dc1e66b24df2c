"""The best design that was found, and the way to it: printed, drawn, saved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.report.result import Result
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.design.evaluate import Evaluation
from jaxatt.studies.design.study import DesignStudy
from jaxatt.studies.tables import WORST

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


AGREED = 1e-3
"""Relative difference up to which the independent solve confirms the measure."""


@dataclass(frozen=True, eq=False)
class Flown:
    """What an independent solve of the design and its flights say.

    measured, reached : (M,).  result : of the solve, where there is one target.
    """

    measured: Floats
    reached: npt.NDArray[np.bool_]
    result: Result | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The best design of a study.

    tried : all designs in their order.  best : the last of them, see `Evaluation`.
    flown : its answers, found again independently and flown.
    """

    study: DesignStudy
    tried: Sequence[Evaluation]
    best: Evaluation
    flown: Flown

    @property
    def values(self) -> dict[str, float]:
        """The chosen numbers by their names."""
        return dict(zip(self.study.names, self.best.values.tolist(), strict=True))

    @property
    def measured(self) -> float:
        """Mean or worst of the measure over the targets."""
        return self.study.over_targets(self.best.measured)

    @property
    def reached(self) -> bool:
        """Whether all flights reach, with what was promised of the measure."""
        flown = self.study.over_targets(self.flown.measured)
        return bool(self.flown.reached.all()) and flown <= self.measured * (1.0 + AGREED)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers under stable names, ready for JSON."""
        s = self.study
        return {
            "design": s.name,
            "title": s.title,
            "scenario": s.scenario.name,
            "minimise": s.measure if s.minimised is None else s.names[s.minimised],
            "at_most": {} if s.at_most is None else {s.measure: s.at_most},
            "over": s.over,
            "targets": s.targets,
            "starts": s.scenario.solver.starts,
            "seed": s.scenario.solver.seed,
            "values": self.values,
            s.measure: {
                "mean": float(self.best.measured.mean()),
                "worst": float(self.best.measured.max()),
                "of_each_target": self.best.measured,
                "flown": self.flown.measured,
            },
            "reached": self.flown.reached,
            "confirmed": self.reached,
            "tried": [
                {
                    "values": dict(zip(s.names, e.values.tolist(), strict=True)),
                    s.measure: s.over_targets(e.measured),
                    "from_own_starts": e.fresh,
                }
                for e in self.tried
            ],
        }

    def table(self) -> Table:
        """Return a table with one row a number."""
        s = self.study
        table = Table(
            title=Text(s.title, style="bold"),
            caption=Text("\n".join(self._sentences())),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        table.add_column("number")
        for name in ("chosen", "from", "to"):
            table.add_column(name, justify="right")
        for variable, value in zip(s.variables, self.best.values, strict=True):
            low, high = variable.range.low, variable.range.high
            table.add_row(Text(variable.name), f"{value:.6g}", f"{low:.6g}", f"{high:.6g}")
        return table

    def _sentences(self) -> list[str]:
        s, count = self.study, len(self.study.targets)
        limit = "" if s.at_most is None else f", at most {s.at_most:.6g} is allowed"
        told = f"{s.measure} {self.measured:.6g}{limit}."
        if count > 1:
            told = (
                f"{s.measure} over {count} targets: mean {self.best.measured.mean():.6g}, worst "
                f"{self.best.measured.max():.6g}{limit} ({s.over})."
            )
        flown = s.over_targets(self.flown.measured)
        return [
            told,
            f"{len(self.tried)} designs tried; solved again with another seed: {flown:.6g}, "
            f"{int(self.flown.reached.sum())} of {count} reached when flown.",
        ]

    def plot(self) -> Picture:
        """Plot what was measured, and the numbers, over the designs in their order."""
        s = self.study
        made = picture(7.0, 5.2, s.title)
        above, below = made.subplots(2, 1, sharex=True)
        at = np.arange(1, len(self.tried) + 1)
        measured = np.array([e.measured for e in self.tried])
        fresh = np.array([e.fresh for e in self.tried])
        folded = measured.max(axis=1) if s.over == WORST else measured.mean(axis=1)
        if measured.shape[1] > 1:
            low, high = measured.min(axis=1), measured.max(axis=1)
            above.fill_between(at, low, high, color=colour(5), alpha=0.3, label="all targets")
        above.plot(at, folded, "-", color=colour(0), lw=1.0)
        above.plot(at[fresh], folded[fresh], "o", color=colour(0), label="from its own starts")
        above.plot(at[~fresh], folded[~fresh], ".", color=colour(0), label="from the one before")
        if s.at_most is not None:
            above.axhline(s.at_most, color="#000000", ls="--", lw=0.8, label="at most")
        above.set_ylabel(s.measure)
        shares = np.array([e.shares for e in self.tried])
        for d, name in enumerate(s.names):
            below.plot(at, shares[:, d], ".-", color=colour(d), lw=1.0, label=name)
        below.set_ylim(-0.05, 1.05)
        below.set_ylabel("share of the range")
        below.set_xlabel("design")
        for axes in (above, below):
            tidy(axes)
            axes.legend(fontsize=8, frameon=False)
        return made

    def save(self, folder: str | Path) -> list[Path]:
        """Write design.json and design.png into a folder; return the files."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "design.json")
            save_figure(self.plot(), partial / "design.png")
        return [Path(folder) / f"design.{kind}" for kind in ("json", "png")]

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {value:.6g}" for name, value in self.values.items())
        state = "confirmed" if self.reached else "not confirmed"
        return (
            f"Design({self.study.name}: {values}; {self.study.measure} {self.measured:.6g}, "
            f"{len(self.tried)} designs tried, {state})"
        )

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())
