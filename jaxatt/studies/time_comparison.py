"""Comparison of a turn in free time with printed values: Euler and Runge-Kutta, both targets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.pipeline.solve import solve
from jaxatt.problems.time_optimal.record import time_optimum
from jaxatt.report import plots
from jaxatt.report.folder import save as save_result
from jaxatt.report.result import Result
from jaxatt.report.summary import summary
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.eigenaxis_time import eigenaxis_time, has_no_gyroscopic_torque
from jaxatt.studies.time_table import time_table

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


_EULER_TOLERANCE_DEG = 2.0
"""Forward Euler ends some way off when flown; that is reported rather than refused."""


@dataclass(frozen=True)
class TimeRow:
    """Figures of one optimum.

    angle_rad : of the turn.  integration : "euler" or "rk4".  final_time_s, step_s, cost_s : [s].
    control_effort : [(N m)^2 s].  attitude_error_deg : flown with fine steps.
    share_at_best : of all starts.  time_s : wall clock, compilation included.
    """

    angle_rad: float
    integration: str
    reached: bool
    final_time_s: float
    step_s: float
    cost_s: float
    control_effort: float
    attitude_error_deg: float
    starts: int
    share_at_best: float
    minima: int
    violation: float
    stationarity: float
    time_s: float


@dataclass(frozen=True, eq=False)
class TimeComparison:
    """Table of the optima, and the results behind them by angle and integration.

    findings : what the rows say of the printed values, in words.
    """

    scenario: scenarios.Scenario
    rows: tuple[TimeRow, ...]
    results: Mapping[str, Result]
    findings: tuple[str, ...]

    @property
    def reached(self) -> bool:
        """Whether every answer reached its target."""
        return all(row.reached for row in self.rows)

    def table(self) -> Group:
        """Return the comparison as a rich table."""
        rows = [asdict(row) for row in self.rows]
        title = f"{self.scenario.title}; printed: {self.scenario.source}"
        return Group(
            time_table(title, rows, printed_time(self.scenario)),
            *(Text(sentence) for sentence in self.findings),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "rows": [asdict(row) for row in self.rows],
            "printed": dict(self.scenario.printed),
            "findings": list(self.findings),
        }

    def plot(self) -> Picture:
        """Plot all answers side by side."""
        return plots.compare(self.results)

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and a figure, and each result into its own folder below."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "comparison.json")
            save_figure(self.plot(), partial / "comparison.png")
        files = [Path(folder) / name for name in ("comparison.json", "comparison.png")]
        for name, result in self.results.items():
            below = name.replace(" ", "-").replace(",", "")
            files += save_result(result, Path(folder) / below)
        return files

    def __repr__(self) -> str:
        found = ", ".join(f"{name} {row.final_time_s:.6g} s" for name, row in self._named())
        return f"TimeComparison({self.scenario.name}: {found})"

    def _named(self) -> list[tuple[str, TimeRow]]:
        return list(zip(self.results, self.rows, strict=True))

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def compare_times(
    scenario: scenarios.Scenario,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> TimeComparison:
    """Solve a turn with forward Euler and Runge-Kutta, to its target and to any other that is
    printed.

    starts, seed : replace the scenario's own.  report : as in `solve`.
    """
    targets: list[dict[str, Any]] = [{}]
    if "other_target" in scenario.printed:
        other = scenario.printed["other_target"]
        targets.append({f"target.{key}": value for key, value in other.items()})
    results, rows = {}, []
    for target in targets:
        for integration, word in (("euler", "forward Euler"), ("rk4", "Runge-Kutta")):
            case = _changed(scenario, {**target, "transcription.integration": integration})
            name = f"{turn_angle(case):.4g} rad, {word}"
            named = None if report is None else _named(report, name)
            results[name] = solve(case, starts=starts, seed=seed, report=named)
            rows.append(_row(results[name]))
    findings = _findings(scenario, rows)
    return TimeComparison(scenario, tuple(rows), results, findings)


def printed_time(scenario: scenarios.Scenario) -> Mapping[str, Any]:
    """Values that the source prints for the objective: "final_time_s" and "step_s", if any."""
    found = scenario.printed.get(scenario.objective.kind, {})
    return found if isinstance(found, Mapping) else {}


def turn_angle(scenario: scenarios.Scenario) -> float:
    """Angle [rad] between the initial and the target attitude, at most pi; if the roll is free, of
    the axis that is pointed."""
    begin = scenario.initial.q_ob
    alike = abs(float(begin @ scenario.targets[0].facing(begin).q_ob))
    return 2.0 * math.acos(min(1.0, alike))


def _changed(scenario: scenarios.Scenario, changes: dict[str, Any]) -> scenarios.Scenario:
    if changes["transcription.integration"] == "euler":
        own = math.degrees(scenario.targets[0].attitude_tolerance)
        changes = {**changes, "target.attitude_tolerance_deg": max(own, _EULER_TOLERANCE_DEG)}
    return scenarios.replace(scenario, changes)


def _named(report: Report, name: str) -> Report:
    return lambda stage, done: report(f"{stage} ({name})", done)


def _row(result: Result) -> TimeRow:
    numbers, phase = summary(result), result.phases[0]
    optimum = time_optimum(phase)
    return TimeRow(
        angle_rad=turn_angle(result.scenario),
        integration=optimum.integration,
        reached=result.reached,
        final_time_s=phase.final_time,
        step_s=phase.step,
        cost_s=optimum.cost,
        control_effort=phase.quadratic_effort,
        attitude_error_deg=math.degrees(phase.errors["attitude"]),
        starts=numbers["starts"]["requested"],
        share_at_best=optimum.share,
        minima=optimum.minima,
        violation=optimum.violation,
        stationarity=optimum.stationarity,
        time_s=sum(result.time.values()),
    )


def _findings(scenario: scenarios.Scenario, rows: list[TimeRow]) -> tuple[str, ...]:
    """Sentences on whether the source is consistent, which row meets it, and the eigenaxis turn."""
    found = [text for text in (scenario.printed.get("disagreement"),) if isinstance(text, str)]
    printed = printed_time(scenario).get("final_time_s")
    if printed is not None:
        nearest = min(rows, key=lambda row: abs(row.final_time_s - printed))
        found.append(
            f"Of these, {nearest.angle_rad:.4g} rad with {_WORDS[nearest.integration]} comes "
            f"nearest to the printed {printed:g} s: {nearest.final_time_s - printed:+.2g} s."
        )
    return (*found, *_about_one_axis(scenario, rows))


def _about_one_axis(scenario: scenarios.Scenario, rows: list[TimeRow]) -> tuple[str, ...]:
    """Sentence on the turn about a fixed axis with full torque, where it goes from rest to rest."""
    vehicle, begin = scenario.vehicle, scenario.initial
    end = scenario.targets[0].facing(begin.q_ob)
    assert vehicle is not None
    moving = (begin.omega_ob, begin.omega_bw, end.omega_ob)
    q, p = begin.q_ob, end.q_ob
    # The vector part of conj(q) p, the turn from start to target in body axes.
    axis = q[0] * p[1:] - p[0] * q[1:] - np.cross(q[1:], p[1:])
    length = float(np.linalg.norm(axis))
    if any(np.any(part) for part in moving) or length < 1e-9:
        return ()
    if not has_no_gyroscopic_torque(vehicle, axis / length):
        return ()
    angle = turn_angle(scenario)
    sign = 1.0 if float(q @ p) >= 0.0 else -1.0
    alone = eigenaxis_time(vehicle, sign * axis / length, angle)
    fastest = min(row.final_time_s for row in rows if abs(row.angle_rad - angle) < 1e-9)
    return (
        f"A turn of {angle:.4g} rad about its own axis takes at least {alone:.6g} s, "
        f"{100.0 * (alone / fastest - 1.0):.3g} % longer than the shortest found.",
    )


_WORDS = {"euler": "forward Euler", "rk4": "Runge-Kutta"}
