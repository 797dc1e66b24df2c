"""Comparison of PD, L1, L0 and moving L0 on one scenario with the printed values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.record import Valves, sparse_section
from jaxatt.records.wording import OBJECTIVES
from jaxatt.report import plots
from jaxatt.report.folder import save as save_result
from jaxatt.report.result import Result
from jaxatt.report.summary import summary
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.baseline import FlownPD, fly_pd_phases
from jaxatt.studies.controllers_table import comparison_table
from jaxatt.studies.relative_sparsity import attainable

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


@dataclass(frozen=True)
class Printed:
    """Values that the source prints for a controller; None for those that it does not print."""

    active_intervals: int | None = None
    active_outside_windows: int | None = None
    cpu_time_s: float | None = None
    relative_sparsity_percent: float | None = None


@dataclass(frozen=True)
class Row:
    """Figures of one controller.

    With several phases counts are added up and errors are those of the worst phase.

    weighted_active_intervals : sum of h_k over the active intervals, by the scenario's windows,
    whether or not the controller knew of them.  relative_sparsity_percent : active intervals out of
    all.  axes : "body", "wheels" or "actuators", what was optimised; "feedback" for a law, "valves"
    for thrusters fully open or shut.  time_s : wall clock, compilation included.
    """

    controller: str
    reached: bool
    active_intervals: int
    relative_sparsity_percent: float
    active_interval_indices: tuple[int, ...]
    weighted_active_intervals: float
    active_outside_windows: int
    attitude_error_deg: float | None
    rate_error_rad_s: float | None
    waypoint_error_deg: float | None
    state_error: float | None
    final_time_s: float
    l1_effort_Nms: float
    objective_total: float
    starts_reached: int | None
    starts: int | None
    time_s: float | None
    axes: str
    printed: Printed

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Table of the controllers' figures, and the results of the optimised ones by their objective.

    findings : what was found of printed values that the rows do not meet, in words.
    """

    scenario: scenarios.Scenario
    rows: tuple[Row, ...]
    results: Mapping[str, Result]
    findings: tuple[str, ...] = ()

    @property
    def reached(self) -> bool:
        """Whether every optimised controller reached the target."""
        return all(result.reached for result in self.results.values())

    def table(self) -> Group:
        """Return the comparison as a rich table."""
        rows = [row.to_dict() for row in self.rows]
        return comparison_table(self._title, rows, self.scenario.printed, self.findings)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "rows": [row.to_dict() for row in self.rows],
            "printed": dict(self.scenario.printed),
            "findings": list(self.findings),
        }

    def plot(self) -> Picture:
        """Plot all optimised answers side by side."""
        return plots.compare({OBJECTIVES[kind]: r for kind, r in self.results.items()})

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and a figure, and each result into its own folder below."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "comparison.json")
            save_figure(self.plot(), partial / "comparison.png")
        files = [Path(folder) / name for name in ("comparison.json", "comparison.png")]
        for kind, result in self.results.items():
            files += save_result(result, Path(folder) / kind)
        return files

    @property
    def _title(self) -> str:
        table = self.scenario.printed.get("table")
        beside = f"; printed: {self.scenario.source}" if table else ""
        return f"{self.scenario.title}{beside}"

    def __repr__(self) -> str:
        counts = ", ".join(f"{row.controller} {row.active_intervals}" for row in self.rows)
        return f"Comparison({self.scenario.name}: active intervals {counts})"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def compare_controllers(
    scenario: scenarios.Scenario,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> Comparison:
    """Run every controller of the source on a scenario of sparse control.

    The PD law is no optimum and knows no toy; moving L0 needs a cheap window.
    starts, seed : replace the scenario's own.  report : as in `solve`.
    """
    kinds = ["l1", "l0"]
    if scenario.vehicle is not None and scenarios.window_mask(scenario).any():
        kinds.append("moving-l0")
    results = {
        kind: solve(scenario, objective=kind, starts=starts, seed=seed, report=_named(report, kind))
        for kind in kinds
    }
    rows: list[Row] = []
    if scenario.vehicle is not None and scenario.vehicle.thrusters.count:
        rows = [_pd_row("PD, Schmitt", scenario, fly_pd_phases(scenario))]
        for kind, result in results.items():
            rows += [_row(scenario, kind, result), *_valve_rows(scenario, kind, result)]
        return Comparison(scenario, tuple(rows), results, _findings(scenario, report))
    if scenario.vehicle is not None:
        rows = [
            _pd_row("PD, clipped", scenario, fly_pd_phases(scenario)),
            _pd_row("PD, unclipped", scenario, fly_pd_phases(scenario, clipped=False)),
        ]
    rows += [_row(scenario, kind, result) for kind, result in results.items()]
    return Comparison(scenario, tuple(rows), results)


def printed_values(scenario: scenarios.Scenario, kind: str) -> Printed:
    """Values that the source prints for an objective."""
    values = scenario.printed.get(kind, {})
    return Printed(
        values.get("active_intervals"),
        values.get("active_outside_windows"),
        values.get("cpu_time_nlp_s"),
        values.get("relative_sparsity_percent"),
    )


def _named(report: Report | None, kind: str) -> Report | None:
    if report is None:
        return None
    return lambda stage, done: report(f"{stage} ({OBJECTIVES[kind]})", done)


def _counts(scenario: scenarios.Scenario, active: Sequence[Any]) -> dict[str, Any]:
    """Counts of the active intervals of all phases, given as masks (N,)."""
    joined = np.concatenate(active)
    weights = np.tile(scenarios.window_weights(scenario), len(active))
    window = np.tile(scenarios.window_mask(scenario), len(active))
    return {
        "active_intervals": int(joined.sum()),
        "relative_sparsity_percent": 100.0 * float(joined.mean()),
        "active_interval_indices": tuple(np.flatnonzero(joined).tolist()),
        "weighted_active_intervals": float(weights[joined].sum()),
        "active_outside_windows": int((joined & ~window).sum()),
    }


def _row(scenario: scenarios.Scenario, kind: str, result: Result) -> Row:
    numbers = summary(result)
    return Row(
        controller=OBJECTIVES[kind],
        reached=result.reached,
        **_counts(scenario, [phase.active for phase in result.phases]),
        attitude_error_deg=numbers["attitude_error_deg"],
        rate_error_rad_s=numbers["rate_error_rad_s"],
        waypoint_error_deg=numbers["waypoint_error_deg"],
        state_error=numbers["state_error"],
        final_time_s=numbers["final_time_s"],
        l1_effort_Nms=numbers["l1_effort_Nms"],
        objective_total=numbers["objective"]["total"],
        starts_reached=numbers["starts"]["reached_target"],
        starts=numbers["starts"]["requested"],
        time_s=sum(result.time.values()),
        axes=_optimised_in(scenario),
        printed=printed_values(scenario, kind),
    )


def _optimised_in(scenario: scenarios.Scenario) -> str:
    if scenario.vehicle is None:
        return "-"
    return "actuators" if scenario.vehicle.thrusters.count else scenario.control.axes


def _valve_rows(scenario: scenarios.Scenario, kind: str, result: Result) -> list[Row]:
    """Figures of the answer after both kinds of quantisation."""
    found = [sparse_section(phase).quantised for phase in result.phases]
    if not all(found):
        return []
    vehicle, relaxed, rows = scenario.vehicle, _row(scenario, kind, result), []
    assert vehicle is not None
    pushes = np.abs(np.asarray(vehicle.thrusters.distribution)).sum(axis=0)
    impulse = np.asarray(vehicle.thrusters.torque_limit) * pushes
    for number, mode in enumerate(v.mode for v in found[0]):
        valves = [quantised[number] for quantised in found]
        rows.append(
            replace(
                relaxed,
                controller=f"{OBJECTIVES[kind]}, {mode}",
                reached=all(v.reached for v in valves),
                **_counts(scenario, [v.active for v in valves]),
                attitude_error_deg=math.degrees(max(v.errors["attitude"] for v in valves)),
                rate_error_rad_s=max(v.errors["rate"] for v in valves),
                l1_effort_Nms=float(sum(v.on_time @ impulse for v in valves)),
                objective_total=sum(_valve_cost(scenario, v) for v in valves),
                starts_reached=None,
                starts=None,
                time_s=None,
                axes="valves",
                printed=Printed(),
            )
        )
    return rows


def _valve_cost(scenario: scenarios.Scenario, valves: Valves) -> float:
    """The printed cost (11) of openings of whole intervals, where no valve is partly open."""
    weights = scenario.objective
    return (
        weights.rate_weight * valves.errors["rate"] ** 2
        + weights.attitude_weight * (1.0 - math.cos(valves.errors["attitude"] / 2.0))
        + weights.sparsity_weight * float(valves.active.sum())
    )


def _findings(scenario: scenarios.Scenario, report: Report | None) -> tuple[str, ...]:
    """Sentences on whether the printed relative sparsity can be met rest to rest, with the
    evidence.
    """
    percent = printed_values(scenario, "l0").relative_sparsity_percent
    if percent is None:
        return ()
    size = round(percent / 100.0 * scenario.horizon.intervals)
    found = attainable(scenario, size, report)
    return (f"Printed, {percent:g} %, rest to rest: {found.sentence()}",)


def _pd_row(name: str, scenario: scenarios.Scenario, phases: Sequence[FlownPD]) -> Row:
    return Row(
        controller=name,
        reached=all(phase.reached for phase in phases),
        **_counts(scenario, [phase.active for phase in phases]),
        attitude_error_deg=math.degrees(max(phase.errors["attitude"] for phase in phases)),
        rate_error_rad_s=max(phase.errors["rate"] for phase in phases),
        waypoint_error_deg=None
        if scenario.waypoint is None
        else math.degrees(max(phase.errors["waypoint"] for phase in phases)),
        state_error=None,
        final_time_s=scenario.horizon.duration * len(phases),
        l1_effort_Nms=sum(phase.l1_effort for phase in phases),
        objective_total=sum(phase.cost for phase in phases),
        starts_reached=None,
        starts=None,
        time_s=None,
        axes="feedback",
        printed=printed_values(scenario, "pd"),
    )
