"""The family of turns in free time: least time, or time plus effort."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jaxatt.problems.family import Family, PhaseStart, SearchOptions
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import OptimalObjective, SensitiveAnswer
from jaxatt.problems.time_optimal.arcs import Arcs, resolve_switches
from jaxatt.problems.time_optimal.effort_path import effort_path
from jaxatt.problems.time_optimal.file_format import FORMAT
from jaxatt.problems.time_optimal.phase import build_time_task, time_record
from jaxatt.problems.time_optimal.reading import read_time_optimal
from jaxatt.problems.time_optimal.report.sections import TIME_OPTIMAL
from jaxatt.problems.time_optimal.search import FreeTimeFound, search_free_time
from jaxatt.problems.time_optimal.sensitive import objective_of_turn, sensitive_turn
from jaxatt.problems.time_optimal.target_search import search_targets
from jaxatt.problems.time_optimal.targets import answer_targets
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.records.phase import Phase
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report


class TimeAnswer(NamedTuple):
    """Outcome of the search of a turn; arcs : its resolved switches, in minimum time."""

    task: ReorientationTask
    found: FreeTimeFound
    arcs: Arcs | None


class TimeOptimal(Family):
    """Family of turns whose final time is found: minimum time, or time and effort."""

    name = FORMAT.name
    systems = FORMAT.systems
    kinds = FORMAT.kinds
    tables = FORMAT.tables
    sections = TIME_OPTIMAL
    mapped = ("final_time_s",)

    def read(
        self, document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
    ) -> Scenario:
        return read_time_optimal(document, origin, folder, faults)

    def search(
        self, scenario: Scenario, start: PhaseStart, options: SearchOptions, report: Report | None
    ) -> TimeAnswer:
        task = build_time_task(scenario, start)
        found = search_free_time(task, scenario.solver.starts, scenario.solver.seed, report)
        exact = scenario.objective.kind == "minimum-time"
        return TimeAnswer(task, found, resolve_switches(task, found) if exact else None)

    def search_many(self, scenarios: Sequence[Scenario]) -> Sequence[TimeAnswer] | None:
        """Search many weights of effort of one turn, each from its neighbours' answers."""
        first, weights = scenarios[0], [s.objective.effort_weight for s in scenarios]
        same = all(_but_weight(s) == _but_weight(first) for s in scenarios)
        if not same or first.objective.kind != "time-effort" or len(set(weights)) < len(weights):
            return None
        task = build_time_task(first)
        if task.at_target:
            return None
        settings = first.solver
        path = effort_path(task, np.array(weights), settings.starts, settings.seed)
        at = np.searchsorted(path.weights, weights)
        return [
            TimeAnswer(task.weighing(weight), path.found[k], None)
            for weight, k in zip(weights, at, strict=True)
        ]

    def judge(
        self, scenario: Scenario, start: PhaseStart, found: TimeAnswer
    ) -> tuple[Phase, InitialState]:
        return time_record(scenario, start.time, found.task, found.found, found.arcs)

    def answer_targets(self, scenario: Scenario, targets: Floats) -> TargetAnswers | None:
        # Limits on the way may have to be tightened for each answer by itself.
        task = build_time_task(scenario)
        if task.watches or task.form.biased:
            return None
        return answer_targets(task, targets, scenario.solver.starts, scenario.solver.seed)

    def measure(self, scenario: Scenario) -> str:
        return "final_time_s" if scenario.objective.kind == "minimum-time" else "cost"

    def search_targets(
        self,
        scenario: Scenario,
        targets: Floats,
        near: Sequence[TimeAnswer] | None,
        report: Report | None,
    ) -> Sequence[TimeAnswer]:
        task = build_time_task(scenario)
        if task.watches or task.form.biased:
            return super().search_targets(scenario, targets, near, report)
        settings, known = scenario.solver, None if near is None else [each.found for each in near]
        found = search_targets(task, targets, settings.starts, settings.seed, known, report)
        return [
            TimeAnswer(task.aiming_at(q), each, None)
            for q, each in zip(targets, found, strict=True)
        ]

    def sensitive(
        self, scenario: Scenario, start: PhaseStart, found: TimeAnswer
    ) -> SensitiveAnswer:
        return sensitive_turn(scenario, start, found.task, found.found)

    def objective(
        self, scenario: Scenario, start: PhaseStart, found: TimeAnswer
    ) -> OptimalObjective:
        return objective_of_turn(scenario, start, found.task, found.found)


def _but_weight(scenario: Scenario) -> Mapping[str, Any]:
    objective = {**scenario.document["objective"], "effort_weight": None}
    return {**scenario.document, "objective": objective}
