"""A plan over the dates of a year: gain, energy and least charge against the sun's height."""

from __future__ import annotations

import csv
import datetime as dt
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from rich import box
from rich.table import Table as RichTable
from rich.text import Text

from jaxatt.drawing.figure import Picture, colour, picture, tidy
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_text
from jaxatt.environment import kepler, sun
from jaxatt.environment.epoch import J2000, days_since_j2000, parse
from jaxatt.problems.net_power.dates import DatedPlan, plan_on_dates
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Orbit, Scenario
from jaxatt.problems.surroundings import elements_of
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling, replacing
from jaxatt.runtime.json_files import write_json
from jaxatt.runtime.settings import RUNS_ONCE, check_precision

STARTS = 4
"""Starts of a harvest on each date, unless others are asked for."""
_SHOWN = 26
"""Rows of the table in the terminal; the file has all dates."""


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
        stored = np.isfinite(self.capacity)
        return [
            {
                "date": date_text(day),
                "beta_deg": float(np.degrees(self.beta[k])),
                "net_J": _number(self.total[k]),
                "harvests_J": _number(self.harvested[k]),
                "baseline_J": _number(self.baseline[k]),
                "gain_J": _number(self.gain[k]),
                # Of a baseline that earns: of one that loses, a percentage says nothing.
                "gain_percent": (
                    100.0 * float(self.gain[k] / self.baseline[k])
                    if self.baseline[k] > 0.0
                    else None
                ),
                "least_charge_percent": (
                    100.0 * float(self.plans.least_charge[k]) / self.capacity if stored else None
                ),
                "reached": not self.plans.reason[k],
                "reason": self.plans.reason[k],
            }
            for k, day in enumerate(self.plans.days)
        ]

    def table(self) -> RichTable:
        """Table of some dates, evenly apart, and of all that fail."""
        rows = self.rows()
        picked = sorted({round(k) for k in np.linspace(0, len(rows) - 1, min(_SHOWN, len(rows)))})
        table = RichTable(
            title=Text(f"{self.scenario.title}: {len(rows)} dates", style="bold"),
            caption=Text(self._caption(len(picked) < len(rows))),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        names = ("date", "beta [deg]", "all tasks [J]", "harvests [J]", "baseline [J]", "gain [J]")
        for name in (*names, "[%]", "least charge [%]"):
            table.add_column(Text(name), justify="left" if name == "date" else "right")
        keys = ("net_J", "harvests_J", "baseline_J", "gain_J", "gain_percent")
        for k in picked:
            row = rows[k]
            cells = ["" if row[key] is None else f"{row[key]:.1f}" for key in keys]
            least = row["least_charge_percent"]
            charge = "" if least is None else f"{least:.1f}"
            table.add_row(row["date"], f"{row['beta_deg']:.1f}", *cells, charge)
        return table

    def _caption(self, some: bool) -> str:
        lines = ["Some of the dates; year.csv has all."] if some else []
        if self.plans.reached.any():
            gain = self.gain[self.plans.reached]
            lines.append(
                f"Gain over the PD law: {gain.min():.1f} to {gain.max():.1f} J, mean "
                f"{gain.mean():.1f} J; {self.starts} starts a harvest, seed {self.seed}."
            )
        failed = [(r["date"], r["reason"]) for r in self.rows() if not r["reached"]]
        lines.append(
            f"{len(failed)} of {len(self.plans.days)} dates cannot be flown."
            if failed
            else "The plan can be flown on all dates."
        )
        lines += [f"{date}: {reason}" for date, reason in failed]
        return "\n".join(lines)

    def plot(self) -> Picture:
        """Plot energies, gain, least charge and the sun's height over the date."""
        dates = [J2000 + dt.timedelta(days=float(day)) for day in self.plans.days]
        stored = np.isfinite(self.capacity)
        figure = picture(9.0, 8.6 if stored else 6.8, self.scenario.title)
        column = figure.subplots(4 if stored else 3, 1, sharex=True)
        for values, index, words in ((self.harvested, 0, "plan"), (self.baseline, 1, "PD law")):
            column[0].plot(dates, 1e-3 * values, color=colour(index), label=words, linewidth=1.5)
        column[0].set_ylabel("harvests [kJ]")
        column[0].legend(frameon=False, fontsize=8)
        column[1].plot(dates, self.gain, color=colour(2), linewidth=1.5)
        column[1].set_ylabel("gain [J]")
        column[1].set_ylim(bottom=0.0)
        if stored:
            least = 100.0 * self.plans.least_charge / self.capacity
            column[2].plot(dates, least, color=colour(3), linewidth=1.5)
            column[2].set_ylabel("least charge [%]")
        column[-1].plot(dates, np.degrees(self.beta), color=colour(6), linewidth=1.2)
        column[-1].set_ylabel("beta angle [deg]")
        for axes in column:
            tidy(axes)
            for date, failed in zip(dates, ~self.plans.reached, strict=True):
                if failed:
                    axes.axvline(date, color="#D55E00", linewidth=0.8, alpha=0.6)
        return figure

    def save(self, folder: str | Path) -> list[Path]:
        """Write year.csv, year.json and year.png; return the files."""
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
        return [Path(folder) / name for name in ("year.csv", "year.json", "year.png")]

    def __repr__(self) -> str:
        flown = int(self.plans.reached.sum())
        return f"Year({self.scenario.name}: {flown} of {len(self.plans.days)} dates flown)"

    def __str__(self) -> str:
        return as_text(self.table())


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
        beta_angle(scenario.orbit, days),
        np.inf if battery is None else float(battery.capacity),
        count,
        chosen,
    )


def read_dates(text: str, scenario: Scenario) -> Floats:
    """Epochs (D,), days since J2000, of "first:last" or "first:last:step", at the plan's hour.

    step : in days, 1 by default.  Raises `ScenarioError`.
    """
    first, last, step = (*text.split(":"), "1")[:3] if text.count(":") in (1, 2) else ("", "", "")
    try:
        ends = [days_since_j2000(parse(each)) for each in (first, last)]
        apart = float(step)
    except ValueError:
        raise ScenarioError(
            f"--dates {text}: write the first and the last date and, if you like, the days "
            "between, such as 2023-01-01:2023-12-31:7"
        ) from None
    if ends[1] < ends[0] or not 0.0 < apart < float("inf"):
        raise ScenarioError(f"--dates {text}: the last date must not come before the first")
    hour = 0.0
    if scenario.orbit is not None and scenario.orbit.days is not None:
        hour = (scenario.orbit.days + 0.5) % 1.0
    count = int((ends[1] - ends[0]) / apart + 1e-9) + 1
    return np.asarray(ends[0] + hour + apart * np.arange(count, dtype=float), np.float64)


def date_text(days: float) -> str:
    """The date of an epoch, days since J2000."""
    return f"{J2000 + dt.timedelta(days=float(days)):%Y-%m-%d}"


def beta_angle(orbit: Orbit, days: Floats) -> Floats:
    """Angle (D,) [rad] of the sun above the plane of the orbit, which stays where it is."""
    return np.asarray(_beta(elements_of(orbit), orbit.gravitational_parameter, jnp.asarray(days)))


def _above(elements: kepler.KeplerianElements, mu: float, days: jax.Array) -> jax.Array:
    normal = jnp.cross(*kepler.to_state(elements, mu))
    normal = normal / jnp.linalg.norm(normal)
    return jnp.arcsin(jnp.sum(sun.sun_direction(days) * normal[None], axis=-1))


_beta = jax.jit(_above, compiler_options=RUNS_ONCE)


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
