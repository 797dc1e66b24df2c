"""Comparison of a manoeuvre in free time with values printed for many weights of time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group
from rich.text import Text

from jaxatt import scenarios
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.problems.front import FrontRequest
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.registry import family_of
from jaxatt.records.phase import Phase
from jaxatt.report.result import Result
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.energy_comparison import quaternion_error
from jaxatt.studies.weight_findings import weight_findings
from jaxatt.studies.weight_table import weight_figure, weight_table

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


STARTS = 8
"""Starts of each weight, unless others are asked for; an answer may serve any weight."""

_PRINTED = ("net_J", "final_time_s", "quaternion_error", "rate_error")


@dataclass(frozen=True)
class WeightRow:
    """The best manoeuvre for one weight of time, by its fine flight, or what is printed for it.

    time_weight : k3 [W/s].  quaternion_error : 1 - |q' q_ref|.  rate_error : squared [rad^2/s^2].
    cost : (6.2a) [W], of those values.
    """

    time_weight: float
    net_J: float
    final_time_s: float
    quaternion_error: float
    rate_error: float
    cost: float

    @property
    def mean_power_W(self) -> float:
        """Mean net power."""
        return self.net_J / self.final_time_s

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers."""
        return {**asdict(self), "mean_power_W": self.mean_power_W}


@dataclass(frozen=True, eq=False)
class WeightComparison:
    """Best manoeuvres for many weights of time, beside printed ones.

    rows, printed : one for each weight.  phases : records of the flights behind the rows.
    findings : what the rows say of the printed values, in words.
    """

    scenario: scenarios.Scenario
    rows: tuple[WeightRow, ...]
    printed: tuple[WeightRow, ...]
    phases: tuple[Phase, ...]
    findings: tuple[str, ...]

    @property
    def reached(self) -> bool:
        """Whether every manoeuvre ends within the tolerances, where its cost leaves no choice."""
        if self.scenario.objective.terminal == "penalty":
            return True
        return all(phase.reached for phase in self.phases)

    @property
    def results(self) -> Mapping[str, Result]:
        """None: the manoeuvres were solved together, not each as a result of its own."""
        return {}

    def table(self) -> Group:
        """Return the comparison as rich tables."""
        title = f"{self.scenario.title}; printed: {self.scenario.source}"
        rows = [
            {
                **row.to_dict(),
                "attitude_error_deg": math.degrees(phase.errors["attitude"]),
                "claimed_J": net_power(phase).claimed,
                "reached": phase.reached,
            }
            for row, phase in zip(self.rows, self.phases, strict=True)
        ]
        printed = [row.to_dict() for row in self.printed]
        return Group(*weight_table(title, rows, printed), *(Text(text) for text in self.findings))

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON; with the dipoles of every manoeuvre."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "rows": [
                {
                    **row.to_dict(),
                    "claimed_J": net_power(phase).claimed,
                    "reached": phase.reached,
                    "printed": beside.to_dict(),
                    "step_s": phase.step,
                    "dipole_Am2": phase.controls.tolist(),
                }
                for row, beside, phase in zip(self.rows, self.printed, self.phases, strict=True)
            ],
            "findings": list(self.findings),
        }

    def plot(self) -> Picture:
        """Plot net energy over time for all weights, as the source's figure 6.6."""
        return weight_figure(
            self.scenario.title,
            [row.to_dict() for row in self.rows],
            [row.to_dict() for row in self.printed],
        )

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and a figure."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "comparison.json")
            save_figure(self.plot(), partial / "comparison.png")
        return [Path(folder) / name for name in ("comparison.json", "comparison.png")]

    def __repr__(self) -> str:
        costs = ", ".join(f"{row.time_weight:g}: {row.cost:.6g}" for row in self.rows)
        return f"WeightComparison({self.scenario.name}, cost by weight of time {costs})"

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def compare_weights(
    scenario: scenarios.Scenario,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> WeightComparison:
    """Solve a manoeuvre in free time for all printed weights of time at once.

    starts : for each weight, `STARTS` by default.  seed : replaces the scenario's own.
    report : as in `solve`.
    Raises `ScenarioError` where the printed lists do not fit together.
    """
    given = scenario.solver
    solver = replace(
        given,
        starts=min(STARTS, given.starts) if starts is None else starts,
        seed=given.seed if seed is None else seed,
    )
    asked = replace(scenario, solver=solver)
    values = _printed_values(scenario)
    printed = tuple(
        _row(asked, *(float(part) for part in parts)) for parts in zip(*values, strict=True)
    )
    request = FrontRequest("time", len(printed), values[0])
    phases = family_of(asked).front(asked, request, report).phases
    rows = tuple(
        _row(
            asked,
            float(weight),
            net_power(phase).energy.net,
            phase.final_time,
            quaternion_error(phase.errors["attitude"]),
            phase.errors["rate"] ** 2,
        )
        for weight, phase in zip(values[0], phases, strict=True)
    )
    claimed = [net_power(phase).claimed for phase in phases]
    found = weight_findings(rows, printed, claimed, asked.horizon.intervals)
    missed = _missed(rows, phases, asked.objective.terminal == "penalty")
    return WeightComparison(scenario, rows, printed, phases, (*found, *missed))


def _printed_values(scenario: scenarios.Scenario) -> list[np.ndarray]:
    """Weights of time and what is printed for each, (K,) all."""
    lists = [scenario.printed.get(name) for name in ("time_weight_W_s", *_PRINTED)]
    try:
        values = np.asarray(lists, float)
    except (TypeError, ValueError):
        values = np.zeros((0, 0))
    rising = values.ndim == 2 and values.size and bool((np.diff(values[0]) > 0.0).all())
    if not rising or not np.isfinite(values).all() or not (values[[0, 2]] > 0.0).all():
        raise scenarios.ScenarioError(
            f"{scenario.name}: [printed] time_weight_W_s, {', '.join(_PRINTED)}: do not fit "
            "together; give as many numbers in each, rising weights, and weights and times above 0"
        )
    return list(values)


def _row(
    scenario: scenarios.Scenario,
    time_weight: float,
    net: float,
    final_time: float,
    attitude: float,
    rate: float,
) -> WeightRow:
    options = options_of(scenario)
    earned = net / final_time if options.cost == "mean-power" else net
    cost = time_weight * final_time - earned
    cost += options.weights.attitude * attitude + options.weights.rate * rate
    return WeightRow(time_weight, net, final_time, attitude, rate, cost)


def _missed(rows: Sequence[WeightRow], phases: Sequence[Phase], weighed: bool) -> tuple[str, ...]:
    """Sentence on manoeuvres that end off the target; weighed : whether their cost lets them."""
    off = [
        f"{row.time_weight:g} ({math.degrees(phase.errors['attitude']):.2g} deg off)"
        for row, phase in zip(rows, phases, strict=True)
        if not phase.reached
    ]
    if not off:
        return ()
    why = ", as the cost has it" if weighed else ""
    return (f"Outside the tolerances{why}: k3 = {', '.join(off)}.",)
