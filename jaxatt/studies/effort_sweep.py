"""Sweep of the weight rho of effort: time against effort, and the Pareto front between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import Picture, picture
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.problems.time_optimal.effort_path import EffortPath, effort_path
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.records.wording import short
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json

WEIGHTS = tuple(float(f"{10.0 ** (k / 4.0):.4g}") for k in range(-12, 5))
"""rho from 0.001 to 10 [1/(N m)^2], four a decade; the source's figures 6 to 8."""


@dataclass(frozen=True, eq=False)
class EffortCurve:
    """Optima of one scenario for all weights.

    path : final times, efforts and torques.  limits : (n + m,) [N m], of the torques.
    """

    scenario: scenarios.Scenario
    path: EffortPath
    limits: np.ndarray

    @property
    def saturation(self) -> np.ndarray:
        """Largest torque of each optimum as a share of its limit, (R,)."""
        return np.asarray((np.abs(self.path.torques) / self.limits).max(axis=(1, 2)))

    @property
    def straightness(self) -> np.ndarray:
        """R^2 of a straight line fitted to each torque over time, (R, n + m)."""
        torque = self.path.torques
        x = np.arange(torque.shape[1]) - 0.5 * (torque.shape[1] - 1)
        centred = torque - torque.mean(axis=1, keepdims=True)
        total = (centred**2).sum(axis=1)
        explained = np.einsum("k,rkj->rj", x, centred) ** 2 / (x @ x)
        return np.asarray(np.where(total > 0.0, explained / np.maximum(total, 1e-300), 1.0))

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        path = self.path
        return {
            "scenario": self.scenario.name,
            "title": self.scenario.title,
            "effort_weight": path.weights.tolist(),
            "final_time_s": path.final_time.tolist(),
            "control_effort": path.quadratic_effort.tolist(),
            "cost_s": path.cost.tolist(),
            "step_s": path.step.tolist(),
            "largest_torque_share": self.saturation.tolist(),
            "r_squared_of_a_line": self.straightness.tolist(),
            "converged": path.converged.tolist(),
            "reached": path.reached.tolist(),
            "torques_Nm": path.torques.tolist(),
        }


@dataclass(frozen=True, eq=False)
class EffortSweep:
    """Optima of several scenarios for the same weights."""

    curves: tuple[EffortCurve, ...]

    @property
    def reached(self) -> bool:
        """Whether every optimum reached its target."""
        return all(bool(curve.path.reached.all()) for curve in self.curves)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "curves": [curve.to_dict() for curve in self.curves],
            "findings": list(self.findings()),
        }

    def findings(self) -> tuple[str, ...]:
        """Sentences on how time and effort change from each scenario to the next."""
        if len(self.curves) < 2:
            return ()
        names = ", ".join(curve.scenario.name for curve in self.curves)
        times = np.diff([curve.path.final_time for curve in self.curves], axis=0)
        efforts = np.diff([curve.path.quadratic_effort for curve in self.curves], axis=0)
        weights = self.curves[0].path.weights
        return (
            f"Along {names} the time {_along(times < 0.0, weights, 'falls')}.",
            f"Along {names} the effort {_along(efforts > 0.0, weights, 'rises')}.",
        )

    def table(self) -> Group:
        """Return a rich table with one row a weight and scenario."""
        table = Table(title="Time and effort against the weight of effort", title_justify="left")
        for name in ("scenario", "rho", "time [s]", "effort", "largest torque", "R2 of a line"):
            table.add_column(name, justify="left" if name == "scenario" else "right")
        for curve in self.curves:
            path = curve.path
            for i, weight in enumerate(path.weights):
                table.add_row(
                    curve.scenario.name if i == 0 else "",
                    f"{weight:g}",
                    short(float(path.final_time[i]), 6) + ("" if path.reached[i] else " *"),
                    short(float(path.quadratic_effort[i]), 5),
                    f"{100.0 * curve.saturation[i]:.4g} %",
                    ", ".join(f"{r:.3f}" for r in curve.straightness[i]),
                )
        missed = () if self.reached else (Text("* does not reach its target when flown"),)
        return Group(table, *(Text(sentence) for sentence in self.findings()), *missed)

    def plot(self) -> Picture:
        """Plot time and effort against the weight, and against each other."""
        made = picture(13.0, 4.2, "Time and effort")
        left, middle, right = made.subplots(1, 3)
        for curve in self.curves:
            path, label = curve.path, curve.scenario.name
            left.semilogx(path.weights, path.final_time, ".-", label=label)
            middle.semilogx(path.weights, path.quadratic_effort, ".-", label=label)
            right.plot(path.final_time, path.quadratic_effort, ".-", label=label)
        left.set_ylabel("final time [s]")
        middle.set_ylabel("effort [(N m)$^2$ s]")
        for axes in (left, middle):
            axes.set_xlabel(r"weight $\rho$ [1/(N m)$^2$]")
        right.set_xlabel("final time [s]")
        right.set_ylabel("effort [(N m)$^2$ s]")
        right.set_title("Pareto front", fontsize="medium")
        left.legend()
        for axes in (left, middle, right):
            axes.grid(alpha=0.3)
        return made

    def save(self, folder: str | Path) -> list[Path]:
        """Write sweep.json and sweep.png into a folder; return the files."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "sweep.json")
            save_figure(self.plot(), partial / "sweep.png")
        return [Path(folder) / f"sweep.{kind}" for kind in ("json", "png")]

    def __repr__(self) -> str:
        names = ", ".join(curve.scenario.name for curve in self.curves)
        return f"EffortSweep({names}: {len(self.curves[0].path.weights)} weights)"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def sweep_effort(
    cases: Sequence[scenarios.Scenario | str | Path] | scenarios.Scenario | str | Path,
    weights: Iterable[float] = WEIGHTS,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> EffortSweep:
    """Solve "time-effort" scenarios for many weights of effort, each warm-started from a neighbour.

    weights : rho [1/(N m)^2], at least 0.  starts, seed : of the search at the middle weight,
    by default the scenario's.

    Raises `ScenarioError` where a scenario is of another kind or a weight is negative.
    """
    several = [cases] if isinstance(cases, (scenarios.Scenario, str, Path)) else list(cases)
    chosen = np.unique(np.asarray(list(weights), float))
    if not len(chosen) or not np.isfinite(chosen).all() or (chosen < 0.0).any():
        raise scenarios.ScenarioError(
            f"rho = {chosen.tolist()}: give one or more weights of effort, none of them negative"
        )
    loaded = [c if isinstance(c, scenarios.Scenario) else scenarios.load(c) for c in several]
    return EffortSweep(tuple(_curve(case, chosen, starts, seed, report) for case in loaded))


def _curve(
    scenario: scenarios.Scenario,
    weights: np.ndarray,
    starts: int | None,
    seed: int | None,
    report: Report | None,
) -> EffortCurve:
    if scenario.objective.kind != "time-effort":
        raise scenarios.ScenarioError(
            f"{scenario.name}: kind = {scenario.objective.kind} has no weight of effort; choose a "
            "scenario of kind time-effort"
        )
    task = build_time_task(scenario)
    if task.at_target:
        raise scenarios.ScenarioError(
            f"{scenario.name}: the target is the start; there is nothing to weigh"
        )
    told = None if report is None else _named(report, scenario.name)
    count = scenario.solver.starts if starts is None else starts
    chosen = scenario.solver.seed if seed is None else seed
    path = effort_path(task, weights, count, chosen, told)
    wheels, thrusters = task.craft.wheels, task.craft.thrusters
    limits = np.concatenate([np.asarray(wheels.torque_limit), np.asarray(thrusters.torque_limit)])
    return EffortCurve(scenario, path, limits)


def _named(report: Report, name: str) -> Report:
    return lambda stage, done: report(f"{stage} ({name})", done)


def _along(holds: np.ndarray, weights: np.ndarray, verb: str) -> str:
    """Words for the weights at which something holds from every curve to the next."""
    always = holds.all(axis=0)
    if always.all():
        return f"{verb} at every weight"
    if not always.any():
        return f"{verb} at no weight"
    return f"{verb} at rho = {', '.join(f'{w:g}' for w in weights[always])} only"
