"""A plan over the dates of a year: gain, energy and least charge against the sun's height."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.problems.net_power.dates import DatedPlan, plan_on_dates
from jaxatt.problems.reading.dates import moment_of
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling, replacing
from jaxatt.runtime.json_files import write_json
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.year_dates import beta_angle
from jaxatt.studies.year_view import beta_figure, year_figure, year_table

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


STARTS = 4
"""Starts of a harvest on each date, unless others are asked for."""


@dataclass(frozen=True, eq=False)
class Year:
    """A plan on D dates.

    harvested : (D,) [J], net energy of the harvests and baseline : (D,) [J], the same of the PD
    law.  total : (D,) [J], of all tasks.  All are not a number where the plan cannot be flown.
    beta : (D,) [rad], angle of the sun above the plane of the orbit.
    capacity : [J], of the battery; infinite without one.
    """

    scenario: Scenario
    plans: DatedPlan
    harvested: Floats
    baseline: Floats
    total: Floats
    beta: Floats
    capacity: float
    starts: int
    seed: int

    @property
    def reached(self) -> bool:
        """Whether the plan can be flown on every date."""
        return bool(self.plans.reached.all())

    @property
    def gain(self) -> Floats:
        """Energy of the harvests above the baseline, (D,) [J]."""
        gain: Floats = self.harvested - self.baseline
        return gain

    def rows(self) -> list[dict[str, Any]]:
        """One row a date, under the names of the files."""
        return [self._row(k) for k in range(len(self.plans.days))]

    def _row(self, k: int) -> dict[str, Any]:
        # Of a baseline that earns: of one that loses, a percentage says nothing.
        share = self.gain[k] / self.baseline[k] if self.baseline[k] > 0.0 else np.nan
        stored = np.isfinite(self.capacity) and self.plans.reached[k]
        least = self.plans.least_charge[k] if stored else np.nan
        return {
            "date": f"{moment_of(self.plans.days[k]):%Y-%m-%d}",
            "beta_deg": _number(np.degrees(self.beta[k])),
            "net_J": _number(self.total[k]),
            "harvests_J": _number(self.harvested[k]),
            "baseline_J": _number(self.baseline[k]),
            "gain_J": _number(self.gain[k]),
            "gain_percent": _number(100.0 * share),
            "least_charge_percent": _number(100.0 * least / self.capacity),
            "reached": not self.plans.reason[k],
            "reason": self.plans.reason[k],
        }

    def table(self) -> Table:
        """Table of some dates, evenly apart, and of all that fail."""
        made = f"{self.starts} starts a harvest, seed {self.seed}.{self._aged()}"
        return year_table(self.scenario.title, self.rows(), made)

    def _aged(self) -> str:
        """Sentence on how far the orbit may be off; empty where it is no old set of elements."""
        paths = [None if orbit is None else orbit.path for orbit in self.plans.orbits]
        sets = zip(paths, self.plans.days.tolist(), strict=True)
        off = [path.off_by(day) for path, day in sets if isinstance(path, ElementSet)]
        if not off:
            return ""
        return (
            f" By the age of its elements the orbit may be off by up to {1e-3 * max(off):.0f} km."
        )

    def plot(self) -> Picture:
        """Plot energies, gain, least charge and the sun's height over the date."""
        return year_figure(self.scenario.title, self.rows(), self.plans.days)

    def plot_beta(self) -> Picture:
        """Plot energy and gain over the sun's height."""
        return beta_figure(self.scenario.title, self.rows(), self.plans.days)

    def save(self, folder: str | Path) -> list[Path]:
        """Write year.csv, year.json, year.png and beta.png; return the files."""
        rows = self.rows()
        with filling(folder) as partial:
            text = io.StringIO()
            writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
            with replacing(partial / "year.csv") as file:
                file.write_text(text.getvalue(), encoding="utf-8")
            numbers = {
                "scenario": self.scenario.name,
                "starts": self.starts,
                "seed": self.seed,
                "reached": self.reached,
                "dates": rows,
            }
            write_json(numbers, partial / "year.json")
            save_figure(self.plot(), partial / "year.png")
            save_figure(self.plot_beta(), partial / "beta.png")
        names = ("year.csv", "year.json", "year.png", "beta.png")
        return [Path(folder) / name for name in names]

    def __repr__(self) -> str:
        flown = int(self.plans.reached.sum())
        return f"Year({self.scenario.name}: {flown} of {len(self.plans.days)} dates flown)"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def plan_year(
    scenario: Scenario,
    days: Floats,
    *,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> Year:
    """Solve a scenario's plan on other dates, all of a task's dates in one batch.

    days : (D,), epochs since J2000, see `read_dates`.  starts : of a harvest on each date, `STARTS`
    by default.  See `plan_on_dates` for what changes with the date.
    """
    check_precision()
    if scenario.orbit is None or scenario.orbit.days is None:
        raise ScenarioError(
            f"{scenario.origin}: [orbit] epoch: missing, and dates need an orbit with an epoch"
        )
    count = starts or min(STARTS, scenario.solver.starts)
    chosen = scenario.solver.seed if seed is None else seed
    plans = plan_on_dates(scenario, days, count, chosen, report)
    harvest = np.array([task.searched for task in scenario.options.tasks])
    # Where a plan ends early what it earned until then says nothing.
    flown = np.where(plans.reached, 1.0, np.nan)
    battery = None if scenario.vehicle is None else scenario.vehicle.battery
    return Year(
        scenario,
        plans,
        flown * plans.net[:, harvest].sum(axis=1),
        flown * plans.baseline[:, harvest].sum(axis=1),
        flown * plans.net.sum(axis=1),
        beta_angle(plans.orbits, days),
        np.inf if battery is None else float(battery.capacity),
        count,
        chosen,
    )


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
