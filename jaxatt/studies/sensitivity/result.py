"""Sensitivities of a scenario's answer, which print, draw and save themselves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.optimize.sensitivity.record import Sensitivities
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


_SHOWN = 24
_NAMED = 6


@dataclass(frozen=True, eq=False, repr=False)
class ScenarioSensitivities:
    """How the answer of a scenario changes with its numbers.

    label, unit : of the objective.  found : derivatives, active limits and flags; see
    `Sensitivities`.  notes : what was held fixed.
    """

    scenario: Scenario
    label: str
    unit: str
    found: Sensitivities
    notes: tuple[str, ...] = ()

    @property
    def regular(self) -> bool:
        """Whether all derivatives hold."""
        return self.found.regular

    def __getitem__(self, name: str) -> float:
        """Derivative of the objective by a number of the scenario."""
        return self.found[name]

    def rows(self) -> list[dict[str, Any]]:
        """One row a parameter, those of the largest effect first."""
        f, share = self.found, self.found.shares
        return [
            {
                "parameter": f.names[i],
                "value": float(f.values[i]),
                "derivative": float(f.by_parameter[i]),
                "percent_per_percent": float(share[i]),
            }
            for i in f.order
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers under stable names, ready for JSON."""
        f = self.found
        one = f.one_sided
        return {
            "scenario": self.scenario.name,
            "title": self.scenario.title,
            "objective": self.label,
            "unit": self.unit,
            "value": f.objective,
            "starts": self.scenario.solver.starts,
            "seed": self.scenario.solver.seed,
            "regular": f.regular,
            "flags": [{"kind": flag.kind.value, "sentence": flag.sentence} for flag in f.flags],
            "parameters": self.rows(),
            "active_limits": dict(f.active),
            "parameter_order": list(f.names),
            "variables": dict(f.variables),
            "one_sided": None
            if one is None
            else {"forwards": dict(one.forwards), "backwards": dict(one.backwards)},
            "notes": list(self.notes),
        }

    def table(self) -> Table:
        """Return a rich table with one row a parameter, those of the largest effect first."""
        f = self.found
        table = Table(
            title=Text(
                f"{self.scenario.title}: {self.label} {f.objective:.6g} {self.unit}".rstrip(),
                style="bold",
            ),
            caption=Text(self._caption()),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        table.add_column("parameter")
        for name in ("value", f"derivative [{self.unit or 1} / unit]", "% a per cent"):
            table.add_column(Text(name), justify="right")
        for row in self.rows()[:_SHOWN]:
            share = row["percent_per_percent"]
            table.add_row(
                Text(row["parameter"]),
                f"{row['value']:.6g}",
                f"{row['derivative']:+.6g}",
                f"{share:+.4f}" if np.isfinite(share) else "",
            )
        return table

    def _caption(self) -> str:
        f = self.found
        more = len(f.names) - _SHOWN
        lines = [f"{more} more parameters are in sensitivities.json."] if more > 0 else []
        strongest = sorted(f.active.items(), key=lambda item: -abs(item[1]))[:_NAMED]
        named = ", ".join(f"{name} ({value:.3g})" for name, value in strongest)
        lines.append(
            f"{len(f.active)} limits hold" + (f"; the most costly: {named}." if named else ".")
        )
        lines += [f"Not regular, {flag.kind.value}: {flag.sentence}." for flag in f.flags]
        return "\n".join([*lines, *self.notes])

    def plot(self) -> Picture:
        """Plot per cent of the objective for a per cent of each parameter."""
        rows = [r for r in self.rows() if np.isfinite(r["percent_per_percent"])][:_SHOWN][::-1]
        figure = picture(7.0, 1.6 + 0.24 * max(1, len(rows)), self.scenario.title)
        axes = figure.subplots()
        shares = [row["percent_per_percent"] for row in rows]
        colours = [colour(0 if share >= 0.0 else 1) for share in shares]
        axes.barh(range(len(rows)), shares, color=colours)
        axes.set_yticks(range(len(rows)), [row["parameter"] for row in rows], fontsize=8)
        axes.axvline(0.0, color="#000000", linewidth=0.8)
        axes.set_xlabel(f"{self.label}: per cent for a per cent more of the parameter")
        tidy(axes)
        return figure

    def save(self, folder: str | Path) -> list[Path]:
        """Write sensitivities.json and sensitivities.png into a folder; return the files."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "sensitivities.json")
            save_figure(self.plot(), partial / "sensitivities.png")
        return [Path(folder) / f"sensitivities.{kind}" for kind in ("json", "png")]

    def __repr__(self) -> str:
        state = "regular" if self.regular else "not regular"
        return (
            f"ScenarioSensitivities({self.scenario.name}: {self.label} {self.found.objective:.6g}"
            f"{self.unit and ' '}{self.unit}, {len(self.found.names)} parameters, {state})"
        )

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())
