"""A manoeuvre by magnetorquers alone, in free time, as a function of what it depends on."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.optimal_control import OptimalControlProgram, linearisation
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.optimize.sensitivity.curvature import exact_hessian
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.sensitivity.staged import StagedPoint, SteppedConditions
from jaxatt.problems.net_power.magnetic.batch import kept_finite, solve
from jaxatt.problems.net_power.magnetic.manoeuvre import FreeManoeuvre
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.program import magnetic_program
from jaxatt.problems.net_power.magnetic.search import AGAIN, FrontFound
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.problems.net_power.unknowns import check_unknowns
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.runtime.arrays import Floats

_SETTINGS = replace(AGAIN, tolerance=1e-10, barrier=1e-6, max_iterations=200)
"""Of the solve from the answer of the search, which gives the multipliers."""
_EDGES = (1e-3, 2e-3)
"""Width of the shadow's edges, [rad] at least and [rad/s] of a Runge-Kutta step: in a low orbit the
light fades over two of them, so that it moves smoothly with the instants at which it is taken."""

ManoeuvreOf = Callable[[Scenario], FreeManoeuvre]


def sensitive_free_time(
    scenario: Scenario, manoeuvre_of: ManoeuvreOf, found: FrontFound
) -> SensitiveAnswer:
    """The best answer of a search, solved again to the last digit and polished.

    manoeuvre_of : a changed scenario -> its manoeuvre.
    """
    own = manoeuvre_of(scenario)
    check_unknowns(scenario, own.intervals, 3)
    form = found.task.form(True, found.substeps)
    edges = _edges(own, float(found.chosen.final_time[0]), found.substeps)
    near, reference = _solved_again(found, form, edges)

    def arguments(changed: Scenario) -> MagneticParameters:
        wanted = manoeuvre_of(changed)
        # One table of the surroundings, whatever the limits of the final time.
        task = MagneticTask(replace(wanted, shortest=own.shortest, longest=own.longest))
        if task.form(True, found.substeps) != form:
            raise ScenarioError("its kind of manoeuvre would change; its effect is no derivative")
        p = task.sharper(edges)
        sign = np.sign(np.dot(np.asarray(p.reference), reference)) or 1.0
        return replace(
            p,
            best_area=found.task.parameters.best_area,  # of no effect on exact derivatives
            reference=sign * p.reference,
            shortest=jnp.asarray(wanted.shortest),
            longest=jnp.asarray(wanted.longest),
        )

    conditions = SteppedConditions(exact_program(form))
    answer = answer_at(conditions, arguments(scenario), near)
    optimum = Optimum(answer, _reader(conditions), worth=_cost)
    unit = "W" if form.mean_power else "J"
    return SensitiveAnswer(optimum, arguments, "cost", unit, _notes(form, own, edges))


def _edges(manoeuvre: FreeManoeuvre, final_time: float, substeps: int) -> float:
    """Width of the shadow's edges [rad]."""
    least, by_step = _EDGES
    return max(least, by_step * final_time / (manoeuvre.intervals * substeps))


def _solved_again(
    found: FrontFound, form: MagneticForm, edges: float
) -> tuple[StagedPoint, Floats]:
    """Point and multipliers of the best answer, and its reference with the sign of its way."""
    starts, p = found.chosen.starts(found.time_weight), found.task.sharper(edges)
    solution = solve(form, starts, p, _SETTINGS)
    _, u, x = kept_finite(starts, solution)
    count = u.shape[1]
    near = StagedPoint(
        jnp.asarray(x[0, 0, -1:] - np.log(p.final_time)),
        jnp.asarray(x[0, 1:]),
        jnp.asarray(u[0]),
        jnp.zeros((count, 7)),
        jnp.zeros((count, 0)),
        jnp.asarray(solution.rows[0]),
        Bounded(*(jnp.asarray(leaf[0]) for leaf in solution.dual)),
    )
    return near, np.asarray(starts.reference[0])


@functools.cache
def exact_program(form: MagneticForm) -> OptimalControlProgram:
    """Programme with the derivatives of its steps, rather than those of the motion."""
    stepped = replace(magnetic_program(form), linearisation=None)
    # Traced once, for values and for all uses of their differences.
    exact = replace(stepped, linearisation=jax.jit(functools.partial(linearisation, stepped)))
    return replace(exact, lagrangian_hessian=functools.partial(exact_hessian, exact))


def _cost(objective: Array, p: MagneticParameters) -> Array:
    return objective / p.scale


@functools.cache
def _reader(
    conditions: SteppedConditions,
) -> Callable[[StagedPoint, MagneticParameters], Mapping[str, Array]]:
    def read(point: StagedPoint, p: MagneticParameters) -> Mapping[str, Array]:
        x = jnp.concatenate([conditions.first(point, p)[None], point.x])
        return {
            "final_time": jnp.exp(x[-1, -1]),
            "controls": point.u * p.dipole_unit[None],
            "states": jnp.concatenate([x[:, :4], x[:, 4:7] / p.unit], axis=1),
        }

    return read


def _notes(form: MagneticForm, manoeuvre: FreeManoeuvre, edges: float) -> tuple[str, ...]:
    held = f"Way round, intervals and their steps ({form.substeps} in each) stay as they are."
    if manoeuvre.satellite.light.shadow is None:
        return (held,)
    return held, f"The shadow's edges are {edges:.2g} rad wide."
