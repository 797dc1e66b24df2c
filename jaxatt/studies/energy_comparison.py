"""Comparison of the energy of manoeuvres and plans with the PD law and with printed values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Group
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import Picture
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.pipeline.solve import solve
from jaxatt.problems.net_power.record import net_power
from jaxatt.records.phase import Phase
from jaxatt.report import plots
from jaxatt.report.folder import save as save_result
from jaxatt.report.result import Result
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.energy_table import energy_table


@dataclass(frozen=True)
class EnergyRow:
    """Figures of one manoeuvre, or of one task of a plan.

    label : of the row.  mode : of the task; "harvest" for a manoeuvre.
    net_J, baseline_J : of the optimum and of the PD law from the same start; the same where nothing
    is optimised.  quaternion_error : 1 - |q' q_ref|, and rate_error : squared [rad^2/s^2], as
    (5.8) has them; None where the end is free.
    """

    label: str
    mode: str
    reached: bool
    net_J: float
    baseline_J: float | None
    attitude_error_deg: float | None
    quaternion_error: float | None
    rate_error: float | None
    baseline_quaternion_error: float | None
    baseline_rate_error: float | None
    share_at_best: float

    @property
    def gain_J(self) -> float | None:
        """Net energy above the PD law's [J]."""
        return None if self.baseline_J is None else self.net_J - self.baseline_J


@dataclass(frozen=True, eq=False)
class EnergyComparison:
    """Table of energies beside printed ones, and the result behind it.

    findings : what the rows say of the printed values, in words.
    """

    scenario: scenarios.Scenario
    rows: tuple[EnergyRow, ...]
    results: Mapping[str, Result]
    findings: tuple[str, ...]

    @property
    def reached(self) -> bool:
        """Whether every manoeuvre reached its end."""
        return all(result.reached for result in self.results.values())

    @property
    def printed(self) -> Mapping[str, Mapping[str, float]]:
        """Label of a row -> the values that the source prints for it."""
        rows = self.scenario.printed.get("rows", [])
        return {row["label"]: row for row in rows}

    def table(self) -> Group:
        """Return the comparison as a rich table."""
        title = f"{self.scenario.title}; printed: {self.scenario.source}"
        rows = [_with_gain(row) for row in self.rows]
        return Group(
            *energy_table(title, rows, self.printed), *(Text(text) for text in self.findings)
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "rows": [_with_gain(row) for row in self.rows],
            "printed": dict(self.scenario.printed),
            "findings": list(self.findings),
        }

    def plot(self) -> Picture:
        """Plot the result's overview."""
        return plots.plot(next(iter(self.results.values())))

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and a figure, and each result into its own folder below."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "comparison.json")
            save_figure(self.plot(), partial / "comparison.png")
        files = [Path(folder) / name for name in ("comparison.json", "comparison.png")]
        for name, result in self.results.items():
            files += save_result(result, Path(folder) / name)
        return files

    def __repr__(self) -> str:
        total = sum(row.net_J for row in self.rows)
        return f"EnergyComparison({self.scenario.name}: net energy {total:.6g} J)"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def compare_energy(
    scenario: scenarios.Scenario,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> EnergyComparison:
    """Solve a manoeuvre, or a plan, and set it beside the PD law and the printed values.

    starts, seed : replace the scenario's own.  report : as in `solve`.
    """
    result = solve(scenario, starts=starts, seed=seed, report=report)
    rows = tuple(energy_row(phase) for phase in result.phases)
    return EnergyComparison(scenario, rows, {"optimum": result}, _findings(scenario, rows))


def energy_row(phase: Phase) -> EnergyRow:
    """Figures of one phase."""
    found = net_power(phase)
    attitude, rate = phase.errors.get("attitude"), phase.errors.get("rate")
    turned, left = found.baseline_errors.get("attitude"), found.baseline_errors.get("rate")
    return EnergyRow(
        label=found.task or "manoeuvre",
        mode=found.mode or "harvest",
        reached=phase.reached,
        net_J=found.energy.net,
        baseline_J=found.energy.baseline,
        attitude_error_deg=None if attitude is None else math.degrees(attitude),
        quaternion_error=None if attitude is None else 1.0 - math.cos(0.5 * attitude),
        rate_error=None if rate is None else rate**2,
        baseline_quaternion_error=None if turned is None else 1.0 - math.cos(0.5 * turned),
        baseline_rate_error=None if left is None else left**2,
        share_at_best=found.share,
    )


def _with_gain(row: EnergyRow) -> dict[str, Any]:
    return {**asdict(row), "gain_J": row.gain_J}


def _findings(scenario: scenarios.Scenario, rows: Sequence[EnergyRow]) -> tuple[str, ...]:
    """Sentences on what earns more than printed, and on totals as the source adds them up."""
    printed = {row["label"]: row for row in scenario.printed.get("rows", [])}
    found = [text for text in (scenario.printed.get("disagreement"),) if isinstance(text, str)]
    known = [row for row in rows if row.label in printed and row.gain_J is not None]
    if not known:
        return tuple(found)
    net, base = (sum(getattr(row, name) for row in known) for name in ("net_J", "baseline_J"))
    asked, law = (
        sum(printed[row.label][name] for row in known) for name in ("net_J", "baseline_J")
    )
    found.append(
        f"Over {'the ' if len(known) > 1 else ''}"
        f"{len(known)} manoeuvre{'s' if len(known) > 1 else ''}: {net:.1f} J, {net - base:+.1f} J "
        f"over the PD law (printed {asked:.1f} J, {asked - law:+.1f} J)."
    )
    if len(rows) > len(known):
        total, all_base = (
            sum(getattr(row, name) or 0.0 for row in rows) for name in ("net_J", "baseline_J")
        )
        found.append(
            f"With imaging and communication: {total:.1f} J, {total - all_base:+.1f} J over the "
            f"PD law{_share(total, all_base)}."
        )
    behind = [row.label for row in known if (row.gain_J or 0.0) <= 0.0]
    if behind:
        found.append(f"The PD law earns as much or more in: {', '.join(behind)}.")
    return tuple(found)


def _share(total: float, base: float) -> str:
    return f", {100.0 * (total / base - 1.0):+.3g} %" if base > 0.0 else ""
