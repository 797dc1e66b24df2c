"""Answer of sparse control on its support, as a function of what it depends on.

The count of active intervals does not change with a small change of a parameter.  What does is the
effort that it takes on the support, or the printed cost of it, until the support would have to
change.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.differentiable import differentiable_minimum
from jaxatt.multistart.minimize import Minimum, minimize
from jaxatt.optimize.sensitivity.dense import DenseArguments, DensePoint
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.least_cost import (
    cost_form,
    cost_programme,
    stages_at_epsilon,
    without_leaders,
)
from jaxatt.problems.hands_off.least_effort import effort_programme
from jaxatt.problems.hands_off.search.search import Found
from jaxatt.problems.hands_off.small_programme import SmallProgramme
from jaxatt.problems.hands_off.support import Support, box_on
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.runtime.arrays import Floats

_TOLERANCE = 1e-9


def sensitive_support(
    scenario: Scenario,
    task: SparseTask,
    found: Found,
    build: Callable[[Scenario], SparseTask],
) -> SensitiveAnswer:
    """The answer of a search, with the least effort or the least printed cost on its support.

    task : with its path limits in the programme.  build : a changed scenario -> its task, with the
    same form.
    """
    controls, sign = found.best.controls[0], float(found.best.sign[0])
    support, u = _support(task, controls), task.from_controls(controls)
    if not support.places:
        raise ScenarioError(f"{scenario.name}: the answer is to use no torque; nothing can vary")
    if task.goal.terminal == "penalty":
        # The printed cost knows the nearer way only, wherever the search was headed.
        sign = min(task.ways, key=lambda way: _missed(task, u, way))

    def plant(other: SparseTask) -> object:
        return other.system.turned(other.arguments.plant, jnp.asarray(sign))

    small, least = _polished(scenario, task, support, u, plant(task))

    def whole(scenario: Scenario) -> DenseArguments:
        other = build(scenario)
        if other.system is not task.system:
            raise ScenarioError("it changes which terms the model has")
        own, others = plant(other), len(small.start) - support.size
        args = small.arguments(other, own)
        return DenseArguments((args,), box_on(other.system, support, own, others))

    functions, here = small.functions, whole(scenario)
    answer = differentiable_minimum(
        least,
        functions.objective,
        here.args,
        equality=functions.equality,
        inequality=functions.inequality,
        lower=here.box.lower,
        upper=here.box.upper,
        names=small.names,
    ).answer
    optimum = Optimum(answer, _reader(support, tuple(map(int, np.flatnonzero(task.one_sided)))))
    notes = _notes(task, support, small.label)
    return SensitiveAnswer(optimum, whole, small.label, small.unit, notes)


def _support(task: SparseTask, controls: Floats) -> Support:
    """All controls of active intervals, or the active ones where each counts for itself."""
    free = task.active(controls)
    free = np.broadcast_to(free.any(axis=1, keepdims=True), free.shape) if task.shared else free
    return Support.of(free & (np.asarray(task.arguments.free) > 0.0))


def _missed(task: SparseTask, u: Floats, way: float) -> float:
    """Cost of missing the target, reached one way round, by scaled controls u (N, b)."""
    plant = task.system.turned(task.arguments.plant, jnp.asarray(way))
    rows = np.asarray(task.system.rows(jnp.asarray(u), plant))
    return float(np.sum(np.asarray(task.arguments.row_weight) * rows**2))


def _polished(
    scenario: Scenario, task: SparseTask, support: Support, u: Floats, plant: object
) -> tuple[SmallProgramme, Minimum]:
    """The programme of an answer on its support, and its minimum."""

    def solved(small: SmallProgramme) -> Minimum:
        box = box_on(task.system, support, plant, len(small.start) - support.size)
        return minimize(
            small.functions.objective,
            np.clip(small.start, box.lower, box.upper),
            (small.arguments(task, plant),),
            equality=small.functions.equality,
            inequality=small.functions.inequality,
            lower=box.lower,
            upper=box.upper,
            tolerance=_TOLERANCE,
        )

    if task.goal.terminal == "reach":
        small = effort_programme(task, support, u, plant)
        least = solved(small)
        if least.status not in (Status.CONVERGED, Status.FEASIBLE):
            raise ScenarioError(
                f"{scenario.name}: no control on the support of its answer meets the target in the "
                "model of the search; solve it with more starts"
            )
        return small, least
    form, last = cost_form(task, support, u), None
    while form != last:
        small = cost_programme(task, support, form, u)
        least = solved(small)
        form, last = without_leaders(task, support, form, least.x), form
    corners = stages_at_epsilon(task, support, form, least.x)
    if corners or least.status not in (Status.CONVERGED, Status.FEASIBLE):
        where = f"interval {corners[0]} has come down to epsilon_Nm" if corners else ""
        raise ScenarioError(
            f"{scenario.name}: the printed cost has no smooth minimum on the support of its answer"
            f': {where or least.status.meaning}; use terminal = "reach"'
        )
    return small, least


def _notes(task: SparseTask, support: Support, label: str) -> tuple[str, ...]:
    """What is held fixed."""
    count = len(support.stages)
    notes = [f"The {count} active intervals stay the same; the {label} is the least on them."]
    if task.one_sided.any():
        notes.append(
            "Valves may be partly open: the answer is that before they are quantised, with opening "
            "times that stand for the torques of intervals."
        )
    if task.watches:
        notes.append(
            "Cones, rates and wheel speeds hold at the nodes; what the search tightened them by, "
            "for the way between, stays as it is."
        )
    return tuple(notes)


@functools.cache
def _reader(
    support: Support, valves: tuple[int, ...]
) -> Callable[[DensePoint, DenseArguments], Mapping[str, Array]]:
    """Reader of controls, and of opening times [s] of the columns that are valves."""

    def read(point: DensePoint, args: DenseArguments) -> Mapping[str, Array]:
        own, u = args.args[0], support.spread(point.x)
        found = {"controls": u * own.scale[None]}
        if valves:
            found["opening_times"] = u[:, np.array(valves)] * own.plant.step
        return found

    return read
