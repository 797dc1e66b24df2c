"""A turn in free time as a function of what it depends on."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.optimize.sensitivity.envelope import objective_along
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.sensitivity.staged import StagedConditions, StagedPoint
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import OptimalObjective, SensitiveAnswer
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.problems.time_optimal.search import FreeTimeFound
from jaxatt.problems.time_optimal.task import ReorientationTask, TimeGoal

Arguments = Callable[[Scenario], ReorientationParameters]


def sensitive_turn(
    scenario: Scenario, start: PhaseStart, task: ReorientationTask, found: FreeTimeFound
) -> SensitiveAnswer:
    """The best turn of a search, polished."""
    conditions, arguments, near = _answered(scenario, start, task, found)
    # Its own curvature is right to a few per cent, enough for Newton steps but not for derivatives.
    program = replace(conditions.program, lagrangian_hessian=None)
    answer = answer_at(StagedConditions(program), arguments(scenario), near)
    optimum = Optimum(answer, _reader(program))
    notes: tuple[str, ...] = ()
    if found.constraint_margin.any():
        notes = ("Cones and rates stay tightened by what the search tightened them.",)
    label = "final time" if not scenario.objective.effort_weight else "time and effort"
    return SensitiveAnswer(optimum, arguments, label, "s", notes)


def objective_of_turn(
    scenario: Scenario, start: PhaseStart, task: ReorientationTask, found: FreeTimeFound
) -> OptimalObjective:
    """The objective of the best turn of a search, with the multipliers of its solver.

    Least times are often those of several controls, between which Newton steps cannot decide.
    """
    conditions, arguments, near = _answered(scenario, start, task, found)
    args, best = arguments(scenario), found.best
    return OptimalObjective(
        float(found.cost[best]) if found.answered else np.inf,
        args,
        arguments,
        lambda along: np.asarray(objective_along(conditions, near, args, along)),
    )


def _answered(
    scenario: Scenario, start: PhaseStart, task: ReorientationTask, found: FreeTimeFound
) -> tuple[StagedConditions, Arguments, StagedPoint]:
    """Conditions of the best turn of a search, what they depend on, and where the solver ended.

    Way round, intervals and steps of the integration stay, and so does what cones and limits were
    tightened by.
    """
    if task.at_target:
        raise ScenarioError(f"{scenario.name}: begins at its target; there is nothing to change")
    best = found.best
    task = task.with_substeps(found.substeps)
    sign = -1.0 if found.long_way[best] else 1.0

    def arguments(scenario: Scenario) -> ReorientationParameters:
        return _parameters(scenario, start, task, sign, found)

    args = arguments(scenario)
    states = jnp.asarray(found.states[best])
    count, n = task.intervals, task.program.error_size
    near = StagedPoint(
        states[0, -1:] - jnp.log(args.step),
        states[1:],
        jnp.asarray(found.scaled[best]),
        jnp.zeros((count, n)),
        jnp.zeros((count, 0)),
        jnp.asarray(found.rows[best]),
        Bounded(*(jnp.asarray(leaf[best]) for leaf in found.limits)),
    )
    return StagedConditions(task.program), arguments, near


def _parameters(
    scenario: Scenario,
    start: PhaseStart,
    like: ReorientationTask,
    sign: float,
    found: FreeTimeFound,
) -> ReorientationParameters:
    """Parameters of the same turn of a changed scenario."""
    assert scenario.vehicle is not None
    goal: TimeGoal = replace(
        like.goal,
        effort_weight=scenario.objective.effort_weight,
        shortest=scenario.horizon.shortest,
        longest=scenario.horizon.longest,
    )
    task = ReorientationTask(
        scenario.vehicle,
        start.state or scenario.initial,
        scenario.targets[start.index],
        like.intervals,
        goal,
        scenario.pointing,
    )
    reference = task.reference(sign)
    if float(np.dot(reference, like.reference(sign))) < 0.0 and len(reference) == 4:
        reference = -reference
    margin = found.constraint_margin
    own = (
        task.parameters
        if not margin.any()
        else replace(task.parameters, limits=task.limits(margin))
    )
    return replace(own, reference=jnp.asarray(reference))


@functools.cache
def _reader(
    program: OptimalControlProgram,
) -> Callable[[StagedPoint, ReorientationParameters], Mapping[str, Array]]:
    conditions = StagedConditions(program)

    def read(point: StagedPoint, args: ReorientationParameters) -> Mapping[str, Array]:
        x = jnp.concatenate([conditions.first(point, args)[None], point.x])
        time = jnp.sum(args.share) * jnp.exp(x[-1, -1])
        return {"final_time": time, "controls": point.u * args.scale[None], "states": x[:, :-1]}

    return read
