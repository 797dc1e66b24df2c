"""From a scenario to its verified result."""

from __future__ import annotations

import functools
import importlib.metadata
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt import scenarios
from jaxatt.clock import compile_seconds
from jaxatt.control.pd import PDLaw
from jaxatt.control.schmitt import SchmittLaw
from jaxatt.legs import leg_of
from jaxatt.multistart.final_time import Timed, search_final_time
from jaxatt.multistart.search import Found, Report, search
from jaxatt.multistart.time_cost import Pricing
from jaxatt.problems.slew_case import Departure
from jaxatt.problems.slew_task import SlewTask
from jaxatt.problems.task import Floats, Task, Verdict
from jaxatt.report.result import FinalTimes, Leg, Result
from jaxatt.scenarios.build import build_task
from jaxatt.scenarios.valves import shortest_interval
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
        start_time = sum(leg.final_time for leg in legs)
        build = functools.partial(build_task, leg=index, departure=state, start_time=start_time)
        task, found, tried = _search(scenario, build, guess, inner, report)
        resting_cost += found.resting_cost or 0.0
        flown = time.perf_counter()
        leg, state = leg_of(scenario, task, found, start_time, tried)
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
        notes=scenario.notes,
        extra=(
            {"do_nothing_cost": resting_cost} if scenario.objective.terminal == "penalty" else {}
        ),
    )


def versions() -> Mapping[str, str]:
    """Versions of what made a result."""
    return {name: importlib.metadata.version(name) for name in ("jaxatt", "jax", "jaxlib", "optax")}


Build = Callable[..., Task]
"""As `build_task`, of a given leg."""


def _search(
    scenario: scenarios.Scenario,
    build: Build,
    guess: str | Floats,
    inner: str,
    report: Report | None,
) -> tuple[Task, Found, FinalTimes | None]:
    """Task of a leg, what was found for it, and the final times that were tried."""
    count, seed, horizon = scenario.solver.starts, scenario.solver.seed, scenario.horizon

    def attempt(final_time: float) -> tuple[Task, Found]:
        task = build(scenario, enforce_speed_limits=False, final_time=final_time)
        start = _guess(scenario, build, task, guess)
        found = search(task, count, seed, start, inner, report)
        if isinstance(task, SlewTask) and task.has_speed_limits and _limit_binds(found):
            task = build(scenario, enforce_speed_limits=True, final_time=final_time)
            found = search(task, count, seed, start, inner, report)
        return task, found

    def rebuild(task: Task, final_time: float) -> Task:
        enforced = isinstance(task, SlewTask) and task.form.speed_limited
        return build(scenario, enforce_speed_limits=enforced, final_time=final_time)

    if not horizon.free:
        return *attempt(horizon.duration), None
    shortest = max(horizon.shortest, shortest_interval(scenario.vehicle) * horizon.intervals)
    pricing = Pricing(scenario.objective.time_weight, shortest, horizon.longest)
    timed = search_final_time(attempt, rebuild, pricing, count, seed, report)
    return timed.task, timed.found, _record(pricing, timed)


def _record(pricing: Pricing, timed: Timed) -> FinalTimes:
    trials = timed.trials
    return FinalTimes(
        time_weight=pricing.weight,
        cost=timed.cost,
        final_time=np.array([trial.final_time for trial in trials]),
        costs=np.array([trial.cost for trial in trials]),
        active_intervals=np.array([trial.active_intervals for trial in trials]),
        reached=np.array([trial.reached for trial in trials]),
        how=tuple(trial.how for trial in trials),
    )


def _limit_binds(found: Found) -> bool:
    """Whether path constraints that the search left out matter: then it was not enough."""
    exceeded = (found.starts.verdict.margin_violation > Verdict.MARGIN_TOLERANCE).any()
    return bool(exceeded) or not bool(found.best.verdict.reached[0])


def _guess(
    scenario: scenarios.Scenario,
    build: Build,
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
        l1 = scenarios.replace(scenario, {"objective.kind": "l1"})
        effort = build(l1, final_time=task.final_time)
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
