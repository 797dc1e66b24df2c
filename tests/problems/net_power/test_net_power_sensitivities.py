"""Sensitivities of net-power manoeuvres against solving them again, and what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from solved_again import check_against_solving_again

import jaxatt
from jaxatt import scenarios
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import Answers
from jaxatt.problems.net_power.build import manoeuvre_of
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.unknowns import check_unknowns
from jaxatt.problems.net_power.wheels.sensitive import exact_programme
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.problems.registry import family_of
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer

WHEELS = scenarios.replace(
    scenarios.load("hypso1-netpower"), {"horizon.intervals": 20, "solver.starts": 4}
)
AREA = "vehicle.panels.area_m2.1"
"""Of the panel that earns nearly all: it scales the energy."""
WHEELS_BY = [
    "horizon.horizon_s",
    "vehicle.wheels.torque_limit_Nm",
    "vehicle.wheels.axes.0.1",
    "vehicle.inertia_kgm2.2.2",
    AREA,
    "light.sun_inertial.2",
    "initial.rate_rad_s.0",
    "initial.wheel_speed_rad_s.1",
]


@pytest.mark.slow
def test_derivatives_with_wheels_are_those_of_solving_again():
    sensitive, record, found = check_against_solving_again(WHEELS, WHEELS_BY, cancelling=[AREA])
    family = family_of(WHEELS)
    phase, _ = family.judge(WHEELS, PhaseStart(), found)
    # The same energy, but for the weights of the nodes and the price of effort.
    assert record.objective == pytest.approx(phase.section.energy.net, rel=5e-3)
    assert record["vehicle.wheels.torque_limit_Nm"] > 0.0
    assert (sensitive.label, sensitive.unit) == ("net energy", "J")


def test_the_curvature_is_that_of_the_linearisation():
    rng = np.random.default_rng(4)
    task = wheels_task(manoeuvre_of(WHEELS, PhaseStart()))
    form = task.form
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
    run = jax.jit(lambda: program.lagrangian_hessian(x, u, x_next, stage, p, costate, ()))
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
    with pytest.raises(jaxatt.ScenarioError, match="at most 666 intervals"):
        check_unknowns(WHEELS, 700, 3)
    missed = Solved(np.zeros((1, 20, 3)), None, *np.zeros((5, 1)))
    with pytest.raises(jaxatt.ScenarioError, match="no start reaches"):
        family_of(WHEELS).sensitive(WHEELS, PhaseStart(), Answers(missed))
