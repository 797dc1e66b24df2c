"""Least effort on the support of an answer of sparse control, as a function of what it depends on.

The count of active intervals does not change with a small change of a parameter.  What does is the
effort that it takes on the support, until the support would have to change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.differentiable import differentiable_minimum
from jaxatt.multistart.minimize import minimize
from jaxatt.optimize.sensitivity.dense import DenseArguments, DensePoint
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.least_effort import (
    EffortArguments,
    Support,
    effort_arguments,
    effort_functions,
)
from jaxatt.problems.hands_off.search.search import Found
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer

_TOLERANCE = 1e-9


def sensitive_effort(
    scenario: Scenario,
    task: SparseTask,
    found: Found,
    build: Callable[[Scenario], SparseTask],
) -> SensitiveAnswer:
    """The answer of a search, with the least effort on its support.

    build : a changed scenario -> its task, with the same form.
    """
    if task.goal.terminal != "reach":
        raise ScenarioError(
            f'{scenario.name}: objective.terminal = "penalty" weighs a count; the sensitivities of '
            'sparse answers are those of terminal = "reach"'
        )
    if task.system.bounds is not None:
        raise ScenarioError(
            f"{scenario.name}: has thrusters, which are quantised after the search; sparse answers "
            "have sensitivities with wheels alone"
        )
    if task.watches:
        raise ScenarioError(
            f"{scenario.name}: has cones or limits on the rate; sparse answers have sensitivities "
            "without them"
        )
    best = found.best
    controls, sign = best.controls[0], float(best.sign[0])
    free = task.active(controls)
    free = np.broadcast_to(free.any(axis=1, keepdims=True), free.shape) if task.shared else free
    support = Support.of(free & (np.asarray(task.arguments.free) > 0.0))
    if not support.places:
        raise ScenarioError(f"{scenario.name}: the answer uses no torque; there is nothing to vary")

    def arguments(scenario: Scenario) -> EffortArguments:
        other = build(scenario)
        if other.system is not task.system:
            raise ScenarioError("it changes which terms the model has")
        return effort_arguments(
            other, other.system.turned(other.arguments.plant, jnp.asarray(sign))
        )

    args = arguments(scenario)
    functions = effort_functions(task.system, support)
    u = support.free_of(task.from_controls(controls))
    size = np.abs(
        task.from_controls(controls)[list(support.stages)] @ np.asarray(args.quantities).T
    )
    least = minimize(
        functions.objective,
        np.concatenate([u, size.ravel()]),
        (args,),
        equality=functions.equality,
        inequality=functions.inequality,
        tolerance=_TOLERANCE,
    )
    if least.status not in (Status.CONVERGED, Status.FEASIBLE):
        raise ScenarioError(
            f"{scenario.name}: no control on the support of its answer meets the target in the "
            "model of the search; solve it with more starts"
        )
    answer = differentiable_minimum(
        least,
        functions.objective,
        (args,),
        equality=functions.equality,
        inequality=functions.inequality,
        names=_names(support, len(args.quantities)),
    ).answer

    def whole(scenario: Scenario) -> DenseArguments:
        return DenseArguments((arguments(scenario),), answer.args.box)

    count = len(support.stages)
    note = f"The {count} active intervals stay the same; the effort is the least on them."
    return SensitiveAnswer(
        Optimum(answer, _reader(support)), whole, "effort", task.effort_name, (note,)
    )


def _names(support: Support, quantities: int) -> tuple[str, ...]:
    """Names of the limits on the magnitudes, which come first."""
    pairs = [(k, r) for k in support.stages for r in range(quantities)]
    return tuple(f"quantity {r} {side} 0, interval {k}" for side in (">=", "<=") for k, r in pairs)


def _reader(support: Support) -> Callable[[DensePoint, DenseArguments], Mapping[str, Array]]:
    def read(point: DensePoint, args: DenseArguments) -> Mapping[str, Array]:
        return {"controls": support.spread(point.x) * args.args[0].scale[None]}

    return read
