"""Solve a scenario and verify the answer."""

from __future__ import annotations

import importlib.metadata
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxatt import scenarios
from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.pointing.notes import constraint_margin_notes
from jaxatt.problems.registry import family_of
from jaxatt.records.phase import Phase
from jaxatt.report.result import Result
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.clock import compile_seconds
from jaxatt.runtime.settings import check_precision


def solve(
    scenario: scenarios.Scenario | str | Path,
    *,
    objective: str | None = None,
    terminal: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    guess: str | Floats = "pulses",
    inner: str = "auto",
    report: Report | None = None,
) -> Result:
    """Find the best manoeuvre of a scenario from many starts and fly it again.

    scenario : a `Scenario`, the name of a bundled one or a TOML file.
    objective, terminal, starts, seed : replace the scenario's own settings.
    guess : "pulses" (random), "pd", "l1", or controls (N, b) in the scenario's axes.
    inner : "auto", or an inner minimiser of the augmented Lagrangian, see
    `jaxatt.optimize.augmented_lagrangian.inner`.
    report : called by the host with (stage, starts ended) between chunks of work.

    Raises `ScenarioError` (a `ValueError`) where the scenario does not make sense.
    """
    check_precision()
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    changes: dict[str, Any] = {
        "objective.kind": objective,
        "objective.terminal": terminal,
        "solver.starts": starts,
        "solver.seed": seed,
    }
    changes = {key: value for key, value in changes.items() if value is not None}
    if changes:
        scenario = scenarios.replace(scenario, changes)

    family = family_of(scenario)
    options = SearchOptions(guess, inner)
    family.check(scenario, options)
    return judged(scenario, lambda start: family.search(scenario, start, options, report), report)


def judged(
    scenario: scenarios.Scenario,
    search: Callable[[PhaseStart], Any],
    report: Report | None = None,
) -> Result:
    """Search the phases of a scenario in sequence, fly and judge each, and make the result.

    search : from where a phase begins to what the family's judge wants.
    """
    family = family_of(scenario)
    began, compiled = time.perf_counter(), compile_seconds()
    verifying = 0.0
    start = PhaseStart()
    phases: list[Phase] = []
    answers: list[Any] = []
    # What overflows belongs to a start that does not reach, on the host as in compiled code.
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(family.phases(scenario)):
            answers.append(search(start))
            flown = time.perf_counter()
            phase, end = family.judge(scenario, start, answers[-1])
            verifying += time.perf_counter() - flown
            phases.append(phase)
            start = start.following(phase, end)
        improved = family.improve(scenario, phases, answers, report)
    if improved is not None:
        phases, answers = list(improved.phases), list(improved.found)
    total = time.perf_counter() - began
    compiling = compile_seconds() - compiled
    return Result(
        scenario=scenario,
        phases=tuple(phases),
        seed=scenario.solver.seed,
        time={
            "compile": compiling,
            "solve": max(0.0, total - compiling - verifying),
            "verify": verifying,
        },
        device=str(jax.devices()[0].device_kind),
        precision="float64",
        versions=versions(),
        notes=(
            *scenario.notes,
            *(note for phase in phases for note in constraint_margin_notes(phase)),
        ),
        extra={
            **family.extra(scenario, answers),
            **({} if improved is None else improved.extra),
        },
    )


def versions() -> Mapping[str, str]:
    """Versions of the packages that made a result."""
    return {name: importlib.metadata.version(name) for name in ("jaxatt", "jax", "jaxlib", "optax")}
