"""A stretched plant is the plant of a grid with longer intervals, where nothing moves by itself."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.least_time_program import controls_of, least_time_program, log_ratio
from jaxatt.problems.toy.build import build_toy

CASES = {
    "double-integrator": ({}, 1e-13),
    "van-der-pol": ({}, 1e-13),
    "eseo-3": ({}, 1e-13),
    # So far out the orbit frame hardly turns.
    "hypso1-90-0-0-free": ({"orbit.semi_major_axis_km": 9e5, "orbit.eccentricity": 0.0}, 1e-6),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("ratio", [0.7, 1.0, 1.3])
def test_stretching_is_building_anew(name, ratio):
    changes, tolerance = CASES[name]
    scenario = scenarios.replace(scenarios.load(name), changes)
    build = build_slew if scenario.vehicle is not None else build_toy
    task, longer = build(scenario, final_time=4.0), build(scenario, final_time=4.0 * ratio)
    assert longer.final_time == pytest.approx(4.0 * ratio)
    rng = np.random.default_rng(7)
    u = jnp.asarray(0.3 * rng.uniform(size=(task.intervals, task.size)))
    stretched = task.system.stretched(task.arguments.plant, jnp.asarray(ratio))
    rows = task.system.rows(u, stretched)
    expected = task.system.rows(u, longer.arguments.plant)
    np.testing.assert_allclose(rows, expected, rtol=tolerance, atol=tolerance)

    program = least_time_program(task.system)
    column = np.zeros((task.intervals, 1))
    column[0] = np.log(ratio)
    x = jnp.concatenate([u, jnp.asarray(column)], axis=1)
    assert float(log_ratio(x)) == pytest.approx(np.log(ratio))
    np.testing.assert_array_equal(controls_of(x), u)
    np.testing.assert_allclose(program.equality(x, task.arguments), rows, rtol=1e-12, atol=1e-12)
    free = np.asarray(program.free(x, task.arguments))[:, -1]
    assert free[0] == 1.0 and not free[1:].any()


def test_the_derivative_by_the_step_is_that_of_finite_differences():
    task = build_slew(scenarios.load("hypso1-90-0-0-free"), final_time=30.0)
    program = least_time_program(task.system)
    rng = np.random.default_rng(3)
    u = 0.2 * rng.normal(size=(task.intervals, task.size + 1)) * [*[1.0] * task.size, 0.0]

    def rows(r):
        return program.equality(jnp.asarray(u).at[0, -1].set(r), task.arguments)

    exact = jax.jacfwd(rows)(0.1)
    numeric = (rows(0.1 + 1e-5) - rows(0.1 - 1e-5)) / 2e-5
    np.testing.assert_allclose(exact, numeric, rtol=1e-6, atol=1e-7)
