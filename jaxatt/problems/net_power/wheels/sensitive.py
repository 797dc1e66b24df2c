"""A manoeuvre with wheels as a function of what it depends on."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.optimize.sensitivity.curvature import exact_hessian, exact_path_hessian
from jaxatt.optimize.sensitivity.optimum import Optimum, Worth
from jaxatt.optimize.sensitivity.staged import LinearisedConditions, StagedPoint
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.unknowns import check_unknowns
from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.batch import settings_for, solve_starts
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.programme import terminal_cost, wheels_programme
from jaxatt.problems.net_power.wheels.rolled_out import rolled_out
from jaxatt.problems.net_power.wheels.task import EFFORT, WheelsTask, wheels_task
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.runtime.arrays import Floats

_TOLERANCE, _BARRIER, _PASSES = 1e-10, 1e-5, 200
"""Of the solve from the answer of the search, which gives the multipliers."""
_EDGES = (1e-3, 2e-4)
"""Width of the shadow's edges, [rad] at least and [rad/s] of an interval, of some ten samples of
the light: so that what shines moves smoothly with them."""
ManoeuvreOf = Callable[[Scenario], Manoeuvre]


def sensitive_wheels(
    scenario: Scenario, manoeuvre_of: ManoeuvreOf, solved: Solved, best: int
) -> SensitiveAnswer:
    """One of the answers of a search, solved again to the last digit and polished.

    manoeuvre_of : a changed scenario -> its manoeuvre.  best : index of the answer.
    """
    manoeuvre = replace(manoeuvre_of(scenario), limits=solved.limits)
    edges = _edges(manoeuvre)
    task = wheels_task(manoeuvre, solved.substeps, edges=edges)
    check_unknowns(scenario, len(task.held), task.form.controls)
    near, reference = _solved_again(task, solved.pick(np.array([best])), scenario.solver.starts)
    form = _moving(task.form)

    def arguments(changed: Scenario) -> WheelsParameters:
        again = replace(manoeuvre_of(changed), limits=solved.limits)
        other = wheels_task(again, form.substeps, edges=edges)
        if _moving(other.form) != form:
            raise ScenarioError(
                "what is carried along a manoeuvre would change, e.g. one speed for all wheels to "
                "one for each; its effect is no derivative"
            )
        p = other.parameters
        sign = np.sign(np.dot(np.asarray(p.reference), reference)) or 1.0
        return replace(p, reference=jnp.asarray(sign * np.asarray(p.reference)))

    program = exact_programme(form)
    answer = answer_at(LinearisedConditions(program), arguments(scenario), near)
    optimum = Optimum(answer, _reader(form), worth=_counted(form))
    label = "cost" if form.end == "penalty" else "net energy"
    return SensitiveAnswer(optimum, arguments, label, "J", _notes(form, edges))


def _edges(manoeuvre: Manoeuvre) -> float:
    """Width of the shadow's edges [rad]; 0 where the light has none, or fades by itself."""
    shadow = manoeuvre.satellite.light.shadow
    if manoeuvre.satellite.orbit is None or shadow is None or shadow.penumbra is None:
        return 0.0
    least, by_step = _EDGES
    return max(least, by_step * manoeuvre.step)


def _moving(form: WheelsForm) -> WheelsForm:
    """The same for any momentum: where it is zero, it may change."""
    return replace(form, momentum="constant") if form.momentum == "zero" else form


def _solved_again(task: WheelsTask, answer: Solved, starts: int) -> tuple[StagedPoint, Floats]:
    """Point and multipliers of an answer, and its reference with the sign of the way it goes.

    In a program that the search for so many starts has compiled.
    """
    begin = rolled_out(task, answer.torque, answer.dipole)
    settings = replace(
        settings_for(task.form), tolerance=_TOLERANCE, barrier=_BARRIER, max_iterations=_PASSES
    )
    rows = rows_of_stages(starts, len(task.held))
    found = solve_starts([task], begin, settings, rows=rows)
    count, n = len(task.held), task.form.error_size
    near = StagedPoint(
        jnp.zeros(0),
        jnp.asarray(found.x[0, 1:]),
        jnp.asarray(found.u[0]),
        jnp.zeros((count, n)),
        jnp.zeros((count, 0)),
        jnp.asarray(found.rows[0]),
        Bounded(*(jnp.asarray(leaf[0]) for leaf in found.dual)),
    )
    return near, np.asarray(begin.reference[0])


@functools.cache
def exact_programme(form: WheelsForm) -> OptimalControlProgram:
    """Programme with exact curvature, whose objective counts what is earned at the end, too."""
    programme = wheels_programme(form)
    limited = programme.path_hessian is not None
    return replace(
        programme,
        lagrangian_hessian=functools.partial(exact_hessian, programme),
        path_hessian=functools.partial(exact_path_hessian, programme) if limited else None,
        terminal_cost=functools.partial(terminal_cost, form),
    )


@functools.cache
def _counted(form: WheelsForm) -> Worth:
    """Net energy [J], less the price of effort; the cost [J] where errors are weighed."""

    def counted(objective: Array, p: WheelsParameters) -> Array:
        cost = p.energy_scale * objective + p.load * jnp.sum(p.stages.step)
        if form.power == "signed":
            omega = jnp.stack(at.rate(p.start, p, form))
            cost = cost - p.taken * at.kinetic_energy(p.start, omega, p, form)
        return cost if form.end == "penalty" else -cost

    return counted


@functools.cache
def _reader(form: WheelsForm) -> Callable[[StagedPoint, WheelsParameters], Mapping[str, Array]]:
    def read(point: StagedPoint, p: WheelsParameters) -> Mapping[str, Array]:
        x = jnp.concatenate([p.start[None], point.x])
        omega = jax.vmap(lambda x: jnp.stack(at.rate(x, p, form)))(x)
        controls = jax.vmap(lambda u: at.split(u, form))(point.u)
        found = {
            "controls": controls.scaled * p.torque_limit[None],
            "states": jnp.concatenate([x[:, :4], omega], axis=1),
        }
        if form.dipoles:
            ways = controls.dipoles[:, :3] - controls.dipoles[:, 3:]
            found["dipole"] = ways * p.dipole_limit[None]
        if form.charge:
            found["charge"] = p.energy_scale * x[:, -1]
        return found

    return read


def _notes(form: WheelsForm, edges: float) -> tuple[str, ...]:
    notes = (
        f"Energy by the programme's own count: the sun is weighed at the nodes, and torques cost "
        f"up to {EFFORT:g} of the panels' best power.",
        f"Way round, intervals and their steps ({form.substeps} in each) stay as they are.",
    )
    return (*notes, f"The shadow's edges are {edges:g} rad wide.") if edges else notes
