"""Sensitivities of the answer of a scenario."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.registry import family_of
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.settings import check_precision
from jaxatt.scenarios.catalog import load
from jaxatt.scenarios.loader import replace
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.result import ScenarioSensitivities
from jaxatt.studies.sweep.numbers import places, whole_document


def sensitivities(
    scenario: str | Path | Scenario,
    parameters: Sequence[str] | None = None,
    *,
    starts: int | None = None,
    seed: int | None = None,
    phase: int | None = None,
    report: Report | None = None,
) -> ScenarioSensitivities:
    """Solve a scenario and differentiate its answer by numbers of the scenario.

    parameters : names as in the file, e.g. "vehicle.wheels.torque_limit_Nm",
        "vehicle.inertia_kgm2.0.0" or "vehicle.wheels.axes.*.2"; all numbers that the answer depends
        on by default.
    starts, seed : in place of the scenario's own.
    phase : number of the phase, from 1; may be left out where there is one only.
    report : called with (stage, starts ended).

    Raises `ScenarioError` where a name is no number of the scenario, where it has no such phase, or
    where the answers of its kind have no sensitivities.
    """
    check_precision()
    case = scenario if isinstance(scenario, Scenario) else load(scenario)
    changes = {"solver.starts": starts, "solver.seed": seed}
    given = {key: value for key, value in changes.items() if value is not None}
    case = replace(case, given) if given else case
    for name in parameters or ():
        places(case, whole_document(case), name)  # refused before anything is solved
    answer = sensitive_answer(case, report, phase)
    found = directions_of(case, answer.arguments, parameters)
    record = answer.optimum.along(found.names, found.values, found.along)
    return ScenarioSensitivities(case, answer.label, answer.unit, record, answer.notes)


def sensitive_answer(
    scenario: Scenario, report: Report | None = None, phase: int | None = None
) -> SensitiveAnswer:
    """Search the phases of a scenario up to one, and polish its answer.

    phase : its number, from 1; see `sensitivities`.
    """
    family = family_of(scenario)
    last = _phase_of(scenario, family.phases(scenario), phase)
    start, options = PhaseStart(), SearchOptions()
    family.check(scenario, options)
    for _ in range(last - 1):
        found = family.search(scenario, start, options, report)
        start = start.following(*family.judge(scenario, start, found))
    answer = family.sensitive(scenario, start, family.search(scenario, start, options, report))
    if last == 1:
        return answer
    held = (
        f"Phase {last} begins at {start.time:g} s where the flight of the phase before ended; both "
        "stay."
    )
    return dataclasses.replace(answer, notes=(*answer.notes, held))


def _phase_of(scenario: Scenario, count: int, phase: int | None) -> int:
    """Number of the phase that is asked for, from 1."""
    if phase is None and count > 1:
        raise ScenarioError(
            f"{scenario.name}: has {count} phases, each of which begins where the flight of the "
            f"one before ended; choose one with --phase 1 to {count} (phase=... in Python)"
        )
    if phase is not None and not 1 <= phase <= count:
        there = f"there are 1 to {count}" if count > 1 else "there is one only"
        raise ScenarioError(f"{scenario.name}: phase = {phase}: {there}")
    return phase or 1
