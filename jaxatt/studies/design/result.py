"""The best design that was found, and the way to it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import Picture, colour, picture, tidy
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.report.result import Result
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.design.study import Design


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Numbers that were tried.

    values : (d,).  objectives : (cases,), of the answers.  slopes : (cases, d), their derivatives
    by the numbers as shares of the ranges.
    """

    values: Floats
    objectives: Floats
    slopes: Floats


@dataclass(frozen=True, eq=False, repr=False)
class DesignResult:
    """The best design of a study.

    tried : all evaluations in order.  best : one of them.  flown : the solved and flown cases of
    the best.  settled : whether the descent ended where nothing improves.
    """

    design: Design
    tried: tuple[Evaluation, ...]
    best: Evaluation
    flown: tuple[Result, ...]
    settled: bool

    @property
    def reached(self) -> bool:
        """Whether the flights of all cases of the best design reach, within `at_most`."""
        most = self.design.at_most
        kept = most is None or bool((self.best.objectives <= most * (1.0 + 1e-5)).all())
        return kept and all(phase.reached for result in self.flown for phase in result.phases)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers under stable names, ready for JSON."""
        d = self.design
        return {
            "name": d.name,
            "title": d.title,
            "scenario": d.scenario.name,
            "minimise": d.minimise,
            "at_most": d.at_most,
            "starts": d.scenario.solver.starts,
            "seed": d.scenario.solver.seed,
            "fields": list(d.fields),
            "from": d.lower,
            "to": d.upper,
            "cases": [dict(case) for case in d.cases],
            "best": self.best.values,
            "objectives": self.best.objectives,
            "reached": self.reached,
            "settled": self.settled,
            "tried": [{"values": e.values, "objectives": e.objectives} for e in self.tried],
        }

    def table(self) -> Table:
        """Return a rich table with one row a number."""
        d, first = self.design, self.tried[0]
        table = Table(
            title=Text(d.title, style="bold"),
            caption=Text(self._caption()),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        table.add_column("number")
        for name in ("from", "to", "first", "best"):
            table.add_column(name, justify="right")
        for k, field in enumerate(d.fields):
            numbers = (d.lower[k], d.upper[k], first.values[k], self.best.values[k])
            table.add_row(Text(field), *(f"{value:.6g}" for value in numbers))
        return table

    def _caption(self) -> str:
        first, best = self.tried[0].objectives, self.best.objectives
        lines = [
            f"Objective over {len(best)} cases: mean {best.mean():.6g}, worst {best.max():.6g}; "
            f"first {first.mean():.6g} and {first.max():.6g}.",
            f"{len(self.tried)} designs tried; the cases of the best were solved and flown again: "
            + ("all reach." if self.reached else "not all reach what was asked."),
        ]
        if not self.settled:
            lines.append("The descent ended before it settled; allow it more evaluations.")
        return "\n".join(lines)

    def plot(self) -> Picture:
        """Plot objectives and numbers over the designs that were tried."""
        d = self.design
        figure = picture(7.0, 5.0, d.title)
        above, below = figure.subplots(2, 1, sharex=True)
        at = np.arange(1, len(self.tried) + 1)
        costs = np.array([e.objectives for e in self.tried])
        above.plot(at, costs.mean(axis=1), "o-", color=colour(0), label="mean objective")
        if costs.shape[1] > 1:
            above.plot(at, costs.max(axis=1), "s-", color=colour(1), label="worst objective")
        if d.at_most is not None:
            above.axhline(d.at_most, color="#000000", linestyle="--", label="at most")
        span = d.upper - d.lower
        for k, field in enumerate(d.fields):
            shares = [(e.values[k] - d.lower[k]) / span[k] for e in self.tried]
            below.plot(at, shares, "o-", color=colour(k), label=field)
        below.set_ylabel("share of the range")
        below.set_xlabel("design tried")
        for axes in (above, below):
            tidy(axes)
            axes.legend(fontsize=8)
        return figure

    def save(self, folder: str | Path) -> list[Path]:
        """Write design.json and design.png into a folder; return the files."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "design.json")
            save_figure(self.plot(), partial / "design.png")
        return [Path(folder) / f"design.{kind}" for kind in ("json", "png")]

    def __repr__(self) -> str:
        named = ", ".join(
            f"{field} = {value:.6g}"
            for field, value in zip(self.design.fields, self.best.values, strict=True)
        )
        return f"DesignResult({self.design.name}: {named})"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())
