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
from jaxatt.multistart.candidates import Candidates
from jaxatt.multistart.search import Found, Report, search
from jaxatt.optimize.status import Status
from jaxatt.problems import sparsity
from jaxatt.problems.slew_task import Departure, SlewTask
from jaxatt.problems.task import Floats, Task, Verdict
from jaxatt.problems.toy import ToyTask
from jaxatt.report.result import Leg, Result, StartsRecord
from jaxatt.scenarios.build import build_task
from jaxatt.simulation.flight import Trajectory, fly_law

GUESSES = ("pulses", "pd", "l1")


def solve(
    scenario: scenarios.Scenario | str | Path,
    *,
    objective: str | None = None,
    terminal: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    guess: str | Floats = "pulses",
    inner: str = "gauss-newton",
    report: Report | None = None,
) -> Result:
    """Find the sparsest manoeuvre of a scenario from many starts and fly it again.

    scenario : a `Scenario`, the name of a bundled one or a TOML file.
    objective, terminal, starts, seed : replace the scenario's own settings.
    guess : "pulses" (random), "pd", "l1", or controls (N, b) in the scenario's axes.
    inner : "gauss-newton", "lbfgs" or "adam", see `jaxatt.optimize.inner`.
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
        task = build_task(scenario, index, state)
        found = search(
            task,
            scenario.solver.starts,
            scenario.solver.seed,
            _guess(scenario, index, state, task, guess),
            inner,
            report,
        )
        resting_cost += found.resting_cost or 0.0
        flown = time.perf_counter()
        leg, state = _leg(scenario, task, found, index)
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
        flown = fly_pd(task)
        wheel = flown.wheel_torque[: task.intervals]
        return np.asarray(wheel if task.axes == "wheels" else wheel @ task.craft.wheels.axes.T)
    if guess == "l1":
        effort = build_task(scenarios.replace(scenario, {"objective.kind": "l1"}), leg, state)
        found = search(effort, min(8, scenario.solver.starts), scenario.solver.seed)
        return found.best.controls[0]
    raise ValueError(f"guess = {guess!r}: unknown here; choose one of {', '.join(GUESSES)}")


def fly_pd(task: SlewTask, clipped: bool = True) -> Trajectory:
    """Fly the PD law of (5.8) on the task's slew."""
    law = PDLaw(
        task.craft, jnp.asarray(task.aim.q_ob), jnp.asarray(task.aim.omega_ob), clipped=clipped
    )
    return jax.tree.map(np.asarray, fly_law(task.craft, task.start, law, task.table))


def _leg(
    scenario: scenarios.Scenario, task: Task, found: Found, index: int
) -> tuple[Leg, Departure | None]:
    leg, state = _flown_leg(scenario, task, found, found.best, index)
    if not leg.reached and found.reaching is not None:
        alternative, _ = _flown_leg(scenario, task, found, found.reaching, index)
        leg, state = _flown_leg(scenario, task, found, found.best, index, alternative)
    return leg, state


def _flown_leg(
    scenario: scenarios.Scenario,
    task: Task,
    found: Found,
    answer: Candidates,
    index: int,
    alternative: Leg | None = None,
) -> tuple[Leg, Departure | None]:
    controls = answer.controls
    window = np.asarray(scenarios.window_mask(scenario))
    forbidden = np.asarray(scenarios.forbidden_mask(scenario))
    state = None
    if isinstance(task, SlewTask):
        flown = task.fly(controls)
        verdict, cost = task.judge(flown, controls), task.cost(flown, controls)
        end = task.intervals
        state = Departure(
            *(np.asarray(part[0, end]) for part in (flown.q_ob, flown.omega_ob, flown.omega_bw))
        )
        series = {
            "q_ob": np.asarray(flown.q_ob[0]),
            "omega_ob": np.asarray(flown.omega_ob[0]),
            "omega_ib": np.asarray(flown.omega_ib[0]),
            "omega_bw": np.asarray(flown.omega_bw[0]),
            "torque_body": task.body_torque(controls[0]),
            "torque_wheels": task.wheel_torque(controls[0]),
        }
        reference = {"q_ob": task.aim.q_ob, "omega_ob": task.aim.omega_ob}
        if task.passage is not None:
            reference["waypoint"] = task.passage.q_ob
    else:
        assert isinstance(task, ToyTask)
        verdict, cost = task.verify(controls)
        series = {"state": task.fly(controls)[0], "control": controls[0]}
        reference = {"state": np.asarray(task.parameters.target)}
    xi = np.asarray(
        sparsity.complementarity_vector(
            jnp.asarray(controls[0]), jnp.asarray(task.goal.epsilon), task.shared
        )
    )
    product = np.abs(controls[0]) * (xi[:, None] if task.shared else xi)
    starts = found.starts
    record = StartsRecord(
        status=starts.status,
        reached=starts.verdict.reached,
        active_intervals=(np.abs(starts.controls) > task.threshold).any(axis=2).sum(axis=1),
        effort=task.effort(starts.controls),
        long_way=starts.sign < 0,
        iterations=starts.iterations,
        shortfall=starts.verdict.shortfall,
        distinct_minima=found.distinct_minima,
    )
    reached = bool(verdict.reached[0])
    leg = Leg(
        start_time=index * scenario.horizon.duration,
        step=task.step,
        controls=controls[0],
        weight=np.asarray(task.arguments.weight),
        window=window,
        forbidden=forbidden,
        series=series,
        reference=reference,
        errors={name: float(value[0]) for name, value in verdict.errors.items()},
        tolerances=verdict.tolerances,
        limit_violation=float(verdict.limit_violation[0]),
        margin_violation=float(verdict.margin_violation[0]),
        max_complementarity=float(product.max()),
        objective={name: float(value[0]) for name, value in cost.items()},
        effort=float(task.effort(controls)[0]),
        reached=reached,
        obstacle="" if reached else _obstacle(task, answer),
        active=(np.abs(controls[0]) > task.threshold).any(axis=1),
        starts=record,
        alternative=alternative,
    )
    return leg, state


_ERROR_WORDS = {
    "attitude": "the target attitude",
    "rate": "the target rate",
    "waypoint": "the waypoint's attitude",
    "state": "the target state",
}


def _obstacle(task: Task, answer: Candidates) -> str:
    """Which constraint is in the way of the closest answer, in words."""
    verdict, status = answer.verdict, Status(int(answer.status[0]))
    missed = [
        f"{_ERROR_WORDS[name]} is missed by {error[0] / verdict.tolerances[name]:.3g} times its "
        "tolerance"
        for name, error in verdict.errors.items()
        if not error[0] <= verdict.tolerances[name]
    ]
    if verdict.limit_violation[0] > Verdict.LIMIT_TOLERANCE:
        missed.append(f"a control limit is exceeded by {verdict.limit_violation[0]:.3g}")
    if verdict.margin_violation[0] > Verdict.MARGIN_TOLERANCE:
        missed.append(f"a path constraint is violated by {verdict.margin_violation[0]:.3g}")
    saturated = task.saturated_intervals(answer.controls[0])
    if saturated:
        missed.append(f"the control limit binds in {saturated} of {task.intervals} intervals")
    if status not in (Status.CONVERGED, Status.FEASIBLE):
        missed.append(f"the solver {status.meaning}: {status.remedy}")
    return "; ".join(missed)
