"""A Pareto front that prints, draws and saves itself."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.problems.front import Front
from jaxatt.records.wording import plural, short
from jaxatt.report.summary import named_errors
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import filling, replacing
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.pareto_figure import front_figure

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


@dataclass(frozen=True, eq=False)
class ParetoFront:
    """Points of a scenario's front, and those that are not on it.

    over : "time" or "error".  front : with a record of the flight of every point.
    """

    scenario: scenarios.Scenario
    over: str
    front: Front

    @property
    def reached(self) -> bool:
        """Whether the flight of every point meets what was asked."""
        return bool(self.front.reached.all())

    @property
    def price(self) -> Floats:
        """Gain for a unit of cost since the point before on the front, (K,).

        Not a number for its first point and for points that are not on it.
        """
        front = self.front
        price = np.full(len(front.costs), np.nan)
        order = np.flatnonzero(front.best)
        order = order[np.argsort(front.costs[order])]
        price[order[1:]] = np.diff(front.gains[order]) / np.diff(front.costs[order])
        return price

    def rows(self) -> list[dict[str, Any]]:
        """One row a point, under the names of the files."""
        front, price, best = self.front, self.price, self.front.best
        per = f"price_{front.gain.unit}_per_{front.cost.unit}"
        return [
            {
                front.varied.key: float(front.values[k]),
                front.cost.key: float(front.costs[k]),
                front.gain.key: float(front.gains[k]),
                per: float(price[k]),
                **{name: e for name, e in named_errors(phase).items() if name != front.cost.key},
                "reached": phase.reached,
                "on_front": bool(best[k]),
                "starts_reached": int(phase.starts.reached.sum()),
                "from_neighbour": bool(front.passed_on[k]),
                "reason": phase.failure_reason,
            }
            for k, phase in enumerate(front.phases)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON; with the controls of every point."""
        front = self.front
        other = front.reference
        return {
            "scenario": self.scenario.name,
            "title": self.scenario.title,
            "over": self.over,
            "varied": front.varied.key,
            "cost": front.cost.key,
            "gain": front.gain.key,
            "starts": self.scenario.solver.starts,
            "seed": self.scenario.solver.seed,
            "reached": self.reached,
            "points": [
                {**row, "step_s": phase.step, "controls": phase.controls.tolist()}
                for row, phase in zip(self.rows(), front.phases, strict=True)
            ],
            "beside": None
            if other is None
            else {
                "name": other.name,
                front.cost.key: other.costs.tolist(),
                front.gain.key: other.gains.tolist(),
            },
        }

    def table(self) -> Table:
        """Return a rich table with one row a point."""
        front, best, price = self.front, self.front.best, self.price
        table = Table(
            title=Text(f"{self.scenario.title}: {front.gain.name} over {self.over}", style="bold"),
            caption=Text(self._caption()),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        names = [front.cost.label, front.gain.label]
        names += [f"price [{front.gain.unit}/{front.cost.unit}]", "starts reached", ""]
        if front.varied != front.cost:
            names.insert(0, front.varied.label)
        for name in names:
            table.add_column(Text(name), justify="right" if name else "left")
        for k, phase in enumerate(front.phases):
            cells = [short(front.costs[k]), short(front.gains[k], 6)]
            cells.append(short(price[k]) if np.isfinite(price[k]) else "")
            cells.append(f"{int(phase.starts.reached.sum())} of {len(phase.starts.reached)}")
            cells.append("" if best[k] else "dominated" if phase.reached else "does not reach")
            if front.varied != front.cost:
                cells.insert(0, short(front.values[k]))
            table.add_row(*cells)
        return table

    def _caption(self) -> str:
        front, solver = self.front, self.scenario.solver
        cost, gain = front.cost, front.gain
        lines = [
            f"{int(front.best.sum())} of {plural(len(front.costs), 'point')} on the front; "
            f"{plural(solver.starts, 'start')} a point, seed {solver.seed}; "
            f"{int(front.passed_on.sum())} found from a neighbour's answer.",
            f"Price: {gain.name} for one more {cost.unit} since the point before.",
        ]
        lines += [
            f"{front.varied.name} {front.values[k]:.4g} {front.varied.unit}: {phase.failure_reason}"
            for k, phase in enumerate(front.phases)
            if not phase.reached
        ]
        return "\n".join(lines)

    def plot(self) -> Picture:
        """Plot gain over cost, and its price."""
        return front_figure(self.front, self.price, self.scenario.title)

    def save(self, folder: str | Path) -> list[Path]:
        """Write pareto.csv, pareto.json and pareto.png into a folder; return the files."""
        rows = self.rows()
        text = io.StringIO()
        writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        with filling(folder) as partial:
            with replacing(partial / "pareto.csv") as file:
                file.write_text(text.getvalue(), encoding="utf-8")
            write_json(self.to_dict(), partial / "pareto.json")
            save_figure(self.plot(), partial / "pareto.png")
        return [Path(folder) / f"pareto.{kind}" for kind in ("csv", "json", "png")]

    def __repr__(self) -> str:
        best = int(self.front.best.sum())
        return (
            f"ParetoFront({self.scenario.name} over {self.over}: "
            f"{best} of {len(self.front.costs)} points on the front)"
        )

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())
