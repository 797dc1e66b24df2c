"""Sensitivities of net-power manoeuvres against solving them again, and what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.net_power.answers import Answers
from jaxatt.problems.net_power.build import manoeuvre_of
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.wheels.curvature import exact_hessian
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.sensitive import check_size, exact_programme
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.problems.registry import family_of
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer
from jaxatt.studies.sweep.numbers import places, set_at, value_at, whole_document

STEP = 1e-4
WHEELS = scenarios.replace(
    scenarios.load("hypso1-netpower"), {"horizon.intervals": 20, "solver.starts": 4}
)
WHEELS_BY = [
    "horizon.horizon_s",
    "vehicle.wheels.torque_limit_Nm",
    "vehicle.wheels.axes.0.1",
    "vehicle.inertia_kgm2.2.2",
    "vehicle.panels.area_m2.1",
    "light.sun_inertial.2",
    "initial.rate_rad_s.0",
    "initial.wheel_speed_rad_s.1",
]

SCALES = "vehicle.panels.area_m2.1"
"""Area of the panel that earns nearly all: it scales the energy, and the controls move by what is
left where terms cancel, so that differences of the problem's data show in the fifth digit."""


def with_number(scenario, name, change):
    """The scenario with a number, or all numbers of that name, changed."""
    document = whole_document(scenario)
    for place in places(scenario, document, name):
        set_at(document, place, value_at(document, place) + change)
    return scenarios.from_mapping(document)


def solved_again(scenario, sensitive, name, change):
    """Objective and variables at a changed number, by Newton steps from the answer."""
    optimum, answer = sensitive.optimum, sensitive.optimum.answer
    args = sensitive.arguments(with_number(scenario, name, change))
    again = answer_at(answer.conditions, args, answer.point)
    np.testing.assert_array_equal(again.holding.active, answer.holding.active)
    worth = float(optimum.worth(jnp.asarray(again.objective), args))
    return worth, jax.tree.map(np.asarray, optimum.read(again.point, args))


def check_against_solving_again(scenario, names):
    """Objective and variables at changed numbers, from the first-order conditions there."""
    family = family_of(scenario)
    found = family.search(scenario, PhaseStart(), SearchOptions(), None)
    sensitive = family.sensitive(scenario, PhaseStart(), found)
    optimum = sensitive.optimum
    directions = directions_of(scenario, sensitive.arguments, names)
    record = optimum.along(directions.names, directions.values, directions.along)
    assert record.regular, record.flags
    for k, name in enumerate(names):
        step = STEP * (abs(record.values[k]) or 0.1)
        slopes, moves = [], []
        for width in (step, 2.0 * step):
            ends = [solved_again(scenario, sensitive, name, sign * width) for sign in (1.0, -1.0)]
            slopes.append((ends[0][0] - ends[1][0]) / (2.0 * width))
            moves.append(
                {key: (leaf - ends[1][1][key]) / (2.0 * width) for key, leaf in ends[0][1].items()}
            )
        # Of fourth order: steps that are small enough for the second drown in rounding.
        slope = (4.0 * slopes[0] - slopes[1]) / 3.0
        assert record.by_parameter[k] == pytest.approx(slope, rel=1e-5), name
        for variable, moved in record.variables.items():
            want = (4.0 * moves[0][variable] - moves[1][variable]) / 3.0
            near = 1e-4 if name == SCALES else 1e-6
            assert np.abs(moved[k] - want).max() <= near * np.abs(want).max(), (name, variable)
    return sensitive, record, found


@pytest.mark.slow
def test_derivatives_with_wheels_are_those_of_solving_again():
    sensitive, record, found = check_against_solving_again(WHEELS, WHEELS_BY)
    family = family_of(WHEELS)
    phase, _ = family.judge(WHEELS, PhaseStart(), found)
    # The same energy, but for the weights of the nodes and the price of effort.
    assert record.objective == pytest.approx(phase.section.energy.net, rel=5e-3)
    assert record["vehicle.wheels.torque_limit_Nm"] > 0.0
    assert (sensitive.label, sensitive.unit) == ("net energy", "J")


def test_the_curvature_is_that_of_the_linearisation():
    rng = np.random.default_rng(4)
    task = wheels_task(manoeuvre_of(WHEELS, PhaseStart()))
    form, rows = task.form, Rows(task.form)
    p = jax.tree.map(jnp.asarray, task.parameters)
    stage = jax.tree.map(lambda leaf: leaf[3], p.stages)
    program, n = exact_programme(form), form.error_size
    x = program.retract(p.start, jnp.asarray(0.1 * rng.normal(size=n)))
    u = jnp.asarray(rng.uniform(-1.0, 1.0, form.controls))
    x_next = program.dynamics(x, u, stage, p)
    costate = jnp.asarray(rng.normal(size=n))

    def value(z):
        ahead, cost = program.next_and_cost(program.retract(x, z[:n]), u + z[n:], stage, p)
        return cost + jnp.sum(costate * program.difference(ahead, x_next))

    value, h = jax.jit(value), 1e-3
    ways = np.eye(n + form.controls)
    run = jax.jit(lambda: exact_hessian(rows, x, u, x_next, stage, p, costate, ()))
    found = np.asarray(run())
    want = np.zeros_like(found)
    for i, a in enumerate(ways):
        for j, b in enumerate(ways):
            want[i, j] = sum(
                s * t * float(value(h * (s * a + t * b))) for s in (1, -1) for t in (1, -1)
            )
    np.testing.assert_allclose(found, want / (4.0 * h * h), atol=1e-5 * np.abs(found).max())


def test_what_has_no_sensitivities_is_refused():
    with pytest.raises(jaxatt.ScenarioError, match="phase"):
        sensitive_answer(scenarios.load("hypso2-orbit"))
    many = scenarios.replace(WHEELS, {"horizon.intervals": 700})
    with pytest.raises(jaxatt.ScenarioError, match="at most 666 intervals"):
        check_size(many, wheels_task(manoeuvre_of(many, PhaseStart())))
    free = scenarios.load("mtq-free-time")
    with pytest.raises(jaxatt.ScenarioError, match="in free time"):
        family_of(free).sensitive(free, PhaseStart(), Answers(None, free="found"))
    missed = Solved(np.zeros((1, 20, 3)), None, *np.zeros((5, 1)))
    with pytest.raises(jaxatt.ScenarioError, match="no start reaches"):
        family_of(WHEELS).sensitive(WHEELS, PhaseStart(), Answers(missed))
