"""The toy systems against SciPy."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jaxatt import scenarios
from jaxatt.problems.toy.build import build_toy

RIGHT_SIDES = {
    "double-integrator": lambda x, u: [x[1], u],
    "van-der-pol": lambda x, u: [(1 - x[1] ** 2) * x[0] - x[1] + u, x[0]],
}


@pytest.fixture(params=sorted(RIGHT_SIDES))
def task(request):
    return build_toy(scenarios.load(request.param))


def controls_for(task, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (2, task.intervals, 1))


def reference(task, control):
    states = [np.asarray(task.parameters.start)]
    for u in control[:, 0]:
        done = solve_ivp(
            lambda t, x, u=u: RIGHT_SIDES[task.name](x, u),
            (0, task.step),
            states[-1],
            method="DOP853",
            rtol=1e-11,
            atol=1e-12,
        )
        states.append(done.y[:, -1])
    return np.array(states)


def test_flights_agree_with_scipy(task):
    controls = controls_for(task, 0)
    found = task.fly(controls)
    for each, control in zip(found, controls, strict=True):
        np.testing.assert_allclose(each, reference(task, control), rtol=1e-8, atol=1e-9)


def test_rows_and_margins_are_those_of_the_end_and_of_the_nodes(task):
    controls = controls_for(task, 1)[:1]
    states = reference(task, controls[0])
    u = jnp.asarray(task.from_controls(controls)[0])
    # The optimisation takes four Runge-Kutta steps an interval: 5e-6 off under such a wild control.
    np.testing.assert_allclose(task.system.rows(u, task.parameters), states[-1], atol=2e-5)
    margins = np.asarray(task.system.margins(u, task.parameters))
    if task.name == "van-der-pol":
        np.testing.assert_allclose(margins, states[1:, 1] + 0.25, atol=2e-5)
    else:
        assert margins.shape == (0,)
    verdict, _ = task.verify(controls)
    np.testing.assert_allclose(verdict.errors["state"], np.linalg.norm(states[-1]), rtol=1e-6)
    assert not verdict.reached[0]


def test_van_der_pol_reports_how_far_the_bound_is_broken():
    task = build_toy(scenarios.load("van-der-pol"))
    controls = -np.ones((1, task.intervals, 1))
    states = reference(task, controls[0])
    assert states[:, 1].min() < -0.5
    verdict, _ = task.verify(controls)
    np.testing.assert_allclose(verdict.margin_violation, -0.25 - states[:, 1].min(), rtol=1e-6)


def test_controls_are_clipped_and_thresholded(task):
    u = np.array([[[2.0], [-3.0], [0.5], [1e-7], [-1e-7]]])
    np.testing.assert_array_equal(task.to_controls(u)[0, :, 0], [1.0, -1.0, 0.5, 0.0, 0.0])
    np.testing.assert_allclose(task.l1_effort(task.to_controls(u)), 2.5 * task.step)


def test_analytic_optimum_of_the_double_integrator_arrives():
    """Bang-off-bang with the analytic switches, 1.41886 and 4.58114 s, on a grid with them."""
    task = build_toy(scenarios.load("double-integrator"))
    switch_on, switch_off = 1.4188611699158102, 4.5811388300841898
    grid = np.arange(task.intervals + 1) * task.step

    def share(first, last):
        return np.clip(
            (np.minimum(grid[1:], last) - np.maximum(grid[:-1], first)) / task.step, 0.0, 1.0
        )

    control = (-share(0.0, switch_on) + share(switch_off, 5.0))[None, :, None]
    verdict, _ = task.verify(control)
    assert verdict.errors["state"][0] < 2e-3  # partial intervals at the switches are averaged
    np.testing.assert_allclose(task.l1_effort(control), 1.837722, atol=1e-6)
    np.testing.assert_allclose(task.l1_effort(control), switch_on + 5.0 - switch_off, rtol=1e-9)
