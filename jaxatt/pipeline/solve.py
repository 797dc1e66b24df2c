"""From a scenario to its verified result."""

from __future__ import annotations

import functools
import importlib.metadata
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_task
from jaxatt.problems.hands_off.phase import constraint_margin_notes, phase_record
from jaxatt.problems.hands_off.phase_search import search_phase
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import TIME_KINDS
from jaxatt.problems.time_optimal.phase import time_phase
from jaxatt.records.phase import Phase
from jaxatt.report.result import Result
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.clock import compile_seconds


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
    """Find the sparsest manoeuvre of a scenario from many starts and fly it again.

    scenario : a `Scenario`, the name of a bundled one or a TOML file.
    objective, terminal, starts, seed : replace the scenario's own settings.
    guess : "pulses" (random), "pd", "l1", or controls (N, b) in the scenario's axes.
    inner : "auto", or an inner minimiser of the augmented Lagrangian, see
    `jaxatt.optimize.augmented_lagrangian.inner`. report : called by the host with (stage, starts
    ended) between chunks of work.

    Raises `ScenarioError` (a `ValueError`) where the scenario does not make sense.
    """
    if jnp.result_type(float) != jnp.float64:
        raise ValueError(
            "jax_enable_x64 is off: the solver's tolerances need 64-bit floats; call "
            'jax.config.update("jax_enable_x64", True) before the first use of JAX'
        )
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

    began, compiled = time.perf_counter(), compile_seconds()
    verifying = 0.0
    do_nothing_cost = 0.0
    phases: list[Phase] = []
    state: InitialState | None = None
    if scenario.objective.kind in TIME_KINDS:
        if not isinstance(guess, str) or (guess, inner) != ("pulses", "auto"):
            raise ValueError(
                f"guess, inner: kind = {scenario.objective.kind} has starts and a method of its "
                "own; leave them out"
            )
        phase, verifying = time_phase(scenario, report)
        phases.append(phase)
    for index in range(0 if phases else len(scenario.targets)):
        start_time = sum(phase.final_time for phase in phases)
        build = functools.partial(
            build_task, phase=index, initial_state=state, start_time=start_time
        )
        task, found, tried = search_phase(scenario, build, guess, inner, report)
        do_nothing_cost += found.do_nothing_cost or 0.0
        flown = time.perf_counter()
        phase, state = phase_record(scenario, task, found, start_time, tried)
        phases.append(phase)
        verifying += time.perf_counter() - flown
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
        extra=(
            {"do_nothing_cost": do_nothing_cost} if scenario.objective.terminal == "penalty" else {}
        ),
    )


def versions() -> Mapping[str, str]:
    """Versions of what made a result."""
    return {name: importlib.metadata.version(name) for name in ("jaxatt", "jax", "jaxlib", "optax")}
