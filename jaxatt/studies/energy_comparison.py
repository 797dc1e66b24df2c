"""Comparison of the energy of manoeuvres and plans with the PD law and with printed values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Group
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.pipeline.solve import solve
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.net_power.report.plan_table import totals
from jaxatt.records.phase import Phase
from jaxatt.report import plots
from jaxatt.report.folder import save as save_result
from jaxatt.report.result import Result
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.energy_table import energy_table

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


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


@dataclass(frozen=True)
class Total:
    """Energies of several tasks together [J], of the optimum and of the PD law."""

    label: str
    net_J: float
    baseline_J: float | None


@dataclass(frozen=True, eq=False)
class EnergyComparison:
    """Table of energies beside printed ones, and the result behind it.

    totals : of a plan, as the source's table 5.7 has them; empty for a manoeuvre.
    findings : what the rows say of the printed values, in words.
    """

    scenario: scenarios.Scenario
    rows: tuple[EnergyRow, ...]
    totals: tuple[Total, ...]
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
        sums = _totals_beside(self.scenario, self.totals)
        return Group(
            *energy_table(title, rows, self.printed, sums),
            *(Text(text) for text in self.findings),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "rows": [_with_gain(row) for row in self.rows],
            "totals": [asdict(total) for total in self.totals],
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
    sums: tuple[Total, ...] = ()
    if len(rows) > 1:
        sums = tuple(Total(label, of.net, of.baseline) for label, of in totals(result.phases))
    found = _findings(scenario, rows)
    return EnergyComparison(scenario, rows, sums, {"optimum": result}, found)


def quaternion_error(angle: float) -> float:
    """1 - |q' q_ref| of two attitudes that are an angle [rad] apart, exact for small ones, too."""
    return 2.0 * math.sin(0.25 * angle) ** 2


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
        quaternion_error=None if attitude is None else quaternion_error(attitude),
        rate_error=None if rate is None else rate**2,
        baseline_quaternion_error=None if turned is None else quaternion_error(turned),
        baseline_rate_error=None if left is None else left**2,
        share_at_best=found.share,
    )


def _with_gain(row: EnergyRow) -> dict[str, Any]:
    return {**asdict(row), "gain_J": row.gain_J}


def _totals_beside(
    scenario: scenarios.Scenario, sums: Sequence[Total]
) -> list[tuple[dict[str, Any], dict[str, float]]]:
    """Totals, each with what is printed for it: "totals_J" in the order of table 5.7."""
    printed = [
        {"net_J": net, "baseline_J": base}
        for net, base in zip(
            scenario.printed.get("totals_J", []),
            scenario.printed.get("baseline_totals_J", []),
            strict=True,
        )
    ]
    if len(printed) != len(sums):
        printed = [{}] * len(sums)
    return [(asdict(one), beside) for one, beside in zip(sums, printed, strict=True)]


def _findings(scenario: scenarios.Scenario, rows: Sequence[EnergyRow]) -> tuple[str, ...]:
    """Sentences on what earns more than printed, what does not, and what is not reached."""
    printed = {row["label"]: row for row in scenario.printed.get("rows", [])}
    found = [text for text in (scenario.printed.get("disagreement"),) if isinstance(text, str)]
    known = [row for row in rows if row.label in printed]
    both = [row for row in known if {"net_J", "baseline_J"} <= set(printed[row.label])]
    gains = {row.label: row.gain_J for row in both if row.gain_J is not None}
    if gains:
        asked = {k: printed[k]["net_J"] - printed[k]["baseline_J"] for k in gains}
        found.append(
            f"Gain over the PD law: {sum(gains.values()):+.1f} J{_over(gains)} "
            f"(printed {sum(asked.values()):+.1f} J)."
        )
        less = [label for label, gain in gains.items() if gain < asked[label]]
        if less:
            found.append(f"The gain is less than printed in: {', '.join(less)}.")
        behind = [label for label, gain in gains.items() if gain <= 0.0]
        if behind:
            found.append(f"The PD law earns as much or more in: {', '.join(behind)}.")
    if len(known) > 1:
        found += _on_ends(known, printed)
    searched = [row.share_at_best for row in rows if row.mode == "harvest"]
    if searched:
        least, most = (f"{100.0 * share:.0f}" for share in (min(searched), max(searched)))
        shares = least if least == most else f"{least} to {most}"
        found.append(f"Of the starts {shares} % end at the best.")
    missed = [row.label for row in rows if not row.reached]
    if missed:
        found.append(f"Not flown as asked: {', '.join(missed)}.")
    return tuple(found)


def _over(gains: Mapping[str, Any]) -> str:
    return f" in {len(gains)} manoeuvres" if len(gains) > 1 else ""


def _on_ends(
    known: Sequence[EnergyRow], printed: Mapping[str, Mapping[str, float]]
) -> tuple[str, ...]:
    """Sentence on the largest error at an end, of the flights and of the printed claims."""
    ours = [row.quaternion_error for row in known if row.quaternion_error is not None]
    asked = [printed[row.label].get("quaternion_error") for row in known]
    claimed = [abs(value) for value in asked if value is not None]
    if not ours or not claimed:
        return ()
    return (
        f"The largest 1 - |q' q_ref| is {max(ours):.1e} when flown with fine steps; printed "
        f"{max(claimed):.1e}, by one step an interval.",
    )
