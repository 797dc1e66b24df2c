"""From a scenario to its verified result."""

from __future__ import annotations

import importlib.metadata
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt import scenarios
from jaxatt.clock import compile_seconds
from jaxatt.control.pd import PDLaw
from jaxatt.control.schmitt import SchmittLaw
from jaxatt.legs import guard_notes, leg_of
from jaxatt.multistart.limited_search import search_within_limits
from jaxatt.multistart.search import Report, search
from jaxatt.problems.slew_case import Departure
from jaxatt.problems.slew_task import SlewTask
from jaxatt.problems.task import Floats, Task
from jaxatt.report.result import Leg, Result
from jaxatt.scenarios.build import build_task
from jaxatt.simulation.flight import Trajectory, fly_held_law, fly_law

GUESSES = ("pulses", "pd", "l1")


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
    inner : "auto", or an inner minimiser of the augmented Lagrangian, see `jaxatt.optimize.inner`.
    report : called by the host with (stage, starts ended) between chunks of work.

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
    resting_cost = 0.0
    legs: list[Leg] = []
    state: Departure | None = None
    for index in range(len(scenario.targets)):
        task = build_task(scenario, index, state, enforce_speed_limits=False)
        start = _guess(scenario, index, state, task, guess)
        count, chosen = scenario.solver.starts, scenario.solver.seed
        limited = search_within_limits(task, count, chosen, start, inner, report)
        task, found = limited.task, limited.found
        resting_cost += found.resting_cost or 0.0
        flown = time.perf_counter()
        leg, state = leg_of(scenario, task, found, index)
        legs.append(leg)
        verifying += time.perf_counter() - flown
    total = time.perf_counter() - began
    compiling = compile_seconds() - compiled
    return Result(
        scenario=scenario,
        legs=tuple(legs),
        seed=scenario.solver.seed,
        time={
            "compile": compiling,
            "solve": max(0.0, total - compiling - verifying),
            "verify": verifying,
        },
        device=str(jax.devices()[0].device_kind),
        precision="float64",
        versions=versions(),
        notes=(*scenario.notes, *(note for leg in legs for note in guard_notes(leg))),
        extra=(
            {"do_nothing_cost": resting_cost} if scenario.objective.terminal == "penalty" else {}
        ),
    )


def versions() -> Mapping[str, str]:
    """Versions of what made a result."""
    return {name: importlib.metadata.version(name) for name in ("jaxatt", "jax", "jaxlib", "optax")}


def _guess(
    scenario: scenarios.Scenario,
    leg: int,
    state: Departure | None,
    task: Task,
    guess: str | Floats,
) -> Floats | None:
    if not isinstance(guess, str):
        controls = np.asarray(guess, float)
        if controls.shape != (task.intervals, task.size) or not np.isfinite(controls).all():
            raise ValueError(
                f"guess has shape {controls.shape}: expected finite controls of shape "
                f"({task.intervals}, {task.size})"
            )
        return controls
    if guess == "pulses":
        return None
    if guess == "pd" and isinstance(task, SlewTask):
        return flown_controls(task, fly_pd(task))
    if guess == "l1":
        effort = build_task(scenarios.replace(scenario, {"objective.kind": "l1"}), leg, state)
        found = search(effort, min(8, scenario.solver.starts), scenario.solver.seed)
        return found.best.controls[0]
    raise ValueError(f"guess = {guess!r}: unknown here; choose one of {', '.join(GUESSES)}")


def fly_pd(task: SlewTask, clipped: bool = True) -> Trajectory:
    """Fly the PD law of (5.8) on the task's slew; with thrusters, the one with Schmitt triggers."""
    reference = jnp.asarray(task.aim.q_ob), jnp.asarray(task.aim.omega_ob)
    if task.craft.thrusters.count:
        valves = SchmittLaw(task.craft, *reference)
        flown = fly_held_law(task.craft, task.start, valves, valves.shut, task.table)
    else:
        law = PDLaw(task.craft, *reference, clipped=clipped)
        flown = fly_law(task.craft, task.start, law, task.table)
    return jax.tree.map(np.asarray, flown)


def flown_controls(task: SlewTask, flown: Trajectory) -> Floats:
    """Controls (N, b) of a flight in the task's own axes [N m]."""
    wheel, thrust = flown.wheel_torque[: task.intervals], flown.thrust[: task.intervals]
    if task.axes == "body":
        return np.asarray(wheel @ np.asarray(task.craft.wheels.axes).T)
    return np.concatenate([wheel, thrust], axis=1)
