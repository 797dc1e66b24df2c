"""Sensitivities of turns by magnetorquers alone: their parts, and against solving again."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from solved_again import check_against_solving_again
from test_free_time_search import turn

import jaxatt
from jaxatt import scenarios
from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.optimal_control import fly
from jaxatt.optimize.sensitivity.recursion import product
from jaxatt.optimize.sensitivity.staged import StagedPoint, SteppedConditions
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import Answers
from jaxatt.problems.net_power.build import free_manoeuvre_of
from jaxatt.problems.net_power.magnetic.sensitive import exact_program
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.problems.registry import family_of
from jaxatt.runtime.settings import RUNS_ONCE

AREA = "vehicle.panels.area_m2.3"
"""It hardly moves the final time: the terms of its derivative cancel."""
BY = [
    "objective.time_weight_W_s",
    "vehicle.magnetorquers.dipole_limit_Am2",
    "vehicle.magnetorquers.resistance_ohm",
    "vehicle.inertia_kgm2.2.2",
    AREA,
    "light.irradiance_W_m2",
    "orbit.raan_deg",
    "orbit.semi_major_axis_km",
    "disturbances.residual_dipole_Am2.1",
    "initial.rate_rad_s.0",
    "target.attitude_quaternion.1",
    "target.rate_rad_s.2",
]


@pytest.fixture(scope="module")
def conditions():
    """Conditions of a turn that has to reach, a point anywhere, parameters and limits that hold."""
    rng = np.random.default_rng(11)
    count, n = 5, 7
    scenario = scenarios.replace(turn(900.0), {"horizon.intervals": count})
    task = MagneticTask(free_manoeuvre_of(scenario, PhaseStart()))
    p = jax.tree.map(jnp.asarray, task.sharper(0.5))
    program = exact_program(task.form(True, 2))
    u = jnp.asarray(rng.uniform(-1.0, 1.0, (count, 3)))
    first = jnp.concatenate([p.start, jnp.log(jnp.asarray([300.0]))])
    x, end = fly(program, u, p, first)
    aside = jnp.asarray(0.05 * rng.normal(size=(count, n)))
    random = lambda *shape: jnp.asarray(rng.normal(size=shape))  # noqa: E731
    point = StagedPoint(
        jnp.log(300.0 / p.final_time)[None],
        jax.vmap(program.retract)(jnp.concatenate([x[1:], end[None]]), aside),
        u,
        random(count, n),
        jnp.zeros((count, 0)),
        random(6),
        Bounded(jnp.zeros((count, 0)), random(2), random(count, 3), random(count, 3)),
    )
    active = jax.tree.map(lambda z: z > 0.0, point.limits)
    conditions = SteppedConditions(program)
    return conditions, conditions.released(point, active), p, active


def compiled(run):
    return jax.jit(run, compiler_options=RUNS_ONCE)


@pytest.mark.slow
def test_gradient_and_matrix_are_those_of_the_lagrangian(conditions):
    conditions, point, p, active = conditions
    zero, unflat = ravel_pytree(conditions.zero(point))
    rng, h = np.random.default_rng(5), 1e-3

    @compiled
    def lagrangian(step):
        return conditions.lagrangian(point, unflat(step), p, active)

    @compiled
    def derivatives(step):
        system = conditions.system(point, p)
        slope = conditions.residual(system, point, active)
        bend = product(system.model, active, unflat(step), conditions.program.free_start)
        return ravel_pytree(slope)[0] @ step, ravel_pytree(bend)[0] @ step

    for _ in range(4):
        step = jnp.asarray(rng.normal(size=len(zero)))
        minus2, minus, at, plus, plus2 = (float(lagrangian(k * h * step)) for k in range(-2, 3))
        slope, bend = derivatives(step)
        first = (8.0 * (plus - minus) - (plus2 - minus2)) / (12.0 * h)
        second = (16.0 * (plus + minus) - (plus2 + minus2) - 30.0 * at) / (12.0 * h * h)
        assert float(slope) == pytest.approx(first, rel=1e-7, abs=1e-7)
        assert float(bend) == pytest.approx(second, rel=1e-5, abs=1e-5)


@pytest.mark.slow
def test_the_pull_of_parameters_is_the_change_of_the_gradient(conditions):
    conditions, point, p, active = conditions
    rng, h = np.random.default_rng(6), 1e-5
    along = jax.tree.map(lambda leaf: 0.1 * rng.normal() * leaf, p)
    gradient = compiled(lambda p: ravel_pytree(conditions.gradient(point, p, active))[0])
    ends = [jax.tree.map(lambda a, b, s=s: a + s * h * b, p, along) for s in (1.0, -1.0)]
    want = (gradient(ends[0]) - gradient(ends[1])) / (2.0 * h)
    found = compiled(lambda p: ravel_pytree(conditions.pull(point, p, active, along))[0])(p)
    assert np.abs(want).max() > 0.0
    np.testing.assert_allclose(found, -want, atol=1e-7 * np.abs(want).max())


def test_a_turn_that_misses_its_target_is_refused():
    scenario, missed = turn(900.0), SimpleNamespace(reached=np.array([False]))
    with pytest.raises(jaxatt.ScenarioError, match="no start reaches the target"):
        family_of(scenario).sensitive(scenario, PhaseStart(), Answers(None, free=missed))


@pytest.mark.slow
def test_derivatives_in_free_time_are_those_of_solving_again():
    scenario = scenarios.replace(turn(900.0), {"horizon.intervals": 16, "solver.starts": 4})
    checked = check_against_solving_again(scenario, BY, near=1e-5, cancelling=[AREA])
    sensitive, record, found = checked
    assert found.free is not None
    final = record.variables["final_time"]
    # The envelope theorem: the cost grows by the time itself.
    time = np.exp(float(sensitive.optimum.answer.point.x[-1, -1]))
    assert record["objective.time_weight_W_s"] == pytest.approx(time, rel=1e-9)
    assert final[0] < 0.0
    assert record["vehicle.magnetorquers.dipole_limit_Am2"] < 0.0
    assert (sensitive.label, sensitive.unit) == ("cost", "W")
