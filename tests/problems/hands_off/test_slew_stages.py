"""The slew in stages against its roll-out, its derivatives against differentiation."""

import functools
from dataclasses import replace
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.optimize.optimal_control import exact_derivatives, fly
from jaxatt.optimize.reweighting.staged import StagedReweighting
from jaxatt.optimize.reweighting.weights import Reweighting
from jaxatt.optimize.riccati.lagrangian import RiccatiLagrangian
from jaxatt.optimize.solver import solve
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.polish import POLISH, count_arguments, effort_arguments
from jaxatt.problems.hands_off.slew.model import (
    SlewForm,
    range_margins,
    terminal_rows,
    wheel_speeds,
)
from jaxatt.problems.hands_off.slew.stages import slew_stages
from jaxatt.problems.hands_off.sparse_stages import sparse_stage_roots, sparse_stages
from jaxatt.problems.wheel_speeds import speed_range
from jaxatt.runtime.settings import QUICK_TO_COMPILE, RUNS_ONCE
from jaxatt.spacecraft import reaction_wheels


@functools.cache
def slew(name="hypso1-90-45-15", speed=None, attitude=None, **changes):
    scenario = scenarios.load(name)
    if speed is not None:
        changes = {"vehicle.wheels.speed_limit_rad_s": speed}
    if attitude is not None:
        changes = {"target.attitude_deg": list(attitude)}
    return build_slew(scenarios.replace(scenario, changes) if changes else scenario, 0, None)


def some_torque(task, size=0.02):
    return size * np.random.default_rng(1).normal(size=(task.intervals, task.size))


@pytest.mark.parametrize(
    ("name", "form", "speed"),
    [
        ("hypso1-90-45-15", SlewForm(speed_limited=True), 50.0),
        ("hypso1-90-45-15-perturbed", SlewForm(disturbed=True), None),
        ("hypso1-path", SlewForm(has_waypoint=True), None),
    ],
    ids=["speed limited", "disturbed", "waypoint"],
)
def test_stages_fly_as_the_roll_out_does(name, form, speed):
    task = slew(name, speed)
    args, u = task.arguments, jnp.asarray(some_torque(task))
    program = slew_stages(form, task.size)

    @functools.partial(jax.jit, compiler_options=RUNS_ONCE)
    def both(u):
        nodes, end = fly(program, u, args)
        stage = jax.tree.map(lambda leaf: leaf[7], program.stages(args))
        at = nodes[7], u[7], nodes[8], stage, args
        exact = exact_derivatives(program, *at)
        speeds = wheel_speeds(u, args.plant, form)
        rows = terminal_rows(u, args.plant, form)
        margins = program.final_inequalities(end, args)
        waypoint = jax.vmap(lambda x, k: program.equalities(x, u[0], k, args))(
            nodes, program.stages(args)
        )
        found = program.derivatives(*at)
        return program.final_equalities(end, args), rows, margins, speeds, waypoint, found, exact

    final, rows, margins, speeds, waypoint, found, exact = both(u)
    np.testing.assert_allclose(final[:6], rows[:6], rtol=1e-10, atol=1e-12)
    if form.has_waypoint:
        node = int(args.plant.waypoint_node)
        np.testing.assert_allclose(waypoint[node], rows[6:], rtol=1e-10, atol=1e-12)
    if form.speed_limited:
        relative = np.asarray(speeds[-1]) / speed
        expected = np.concatenate([1.0 - relative, 1.0 + relative])
        np.testing.assert_allclose(margins, expected, rtol=1e-9)
    scale = np.abs(np.asarray(exact)).max(axis=0, keepdims=True)
    assert (np.abs(np.asarray(found - exact)) / scale).max() < 2e-2


@functools.cache
def solver(system, size):
    """Reweighting, then polishing, of lanes (N, b, S), batch axis last."""
    loose = sparse_stage_roots(system, size, True)
    whole = sparse_stages(system, size, True)

    @functools.partial(jax.jit, compiler_options=QUICK_TO_COMPILE)
    def run(u, count, effort, settings):
        def one(u):
            root = solve(StagedReweighting(settings), loose, u, count)
            settled = replace(effort, free=root.support)
            return root, solve(RiccatiLagrangian(POLISH), whole, root.u, settled)

        return jax.vmap(one, in_axes=-1, out_axes=-1)(u)

    return run


@pytest.mark.parametrize("attitude", [(180.0, 0.0, 0.0), (1.0, 0.0, 0.0)], ids=["half", "small"])
def test_slews_of_any_size_arrive(attitude):
    task = slew(attitude=attitude)
    rng = np.random.default_rng(3)
    u = (
        0.003
        * rng.normal(size=(task.intervals, task.size, 4))
        * np.exp(1.5 * rng.normal(size=(task.intervals, 1, 4)))
    )
    u[..., 3] = np.nan
    root, solution = solver(task.system, task.size)(
        jnp.asarray(u), count_arguments(task), effort_arguments(task), Reweighting()
    )
    controls = task.to_controls(np.moveaxis(np.asarray(solution.x), -1, 0)[:3])
    assert task.verify(controls)[0].reached.sum() >= 2
    assert (np.asarray(root.residual)[:3] < 1e-5).sum() >= 2
    status = np.asarray(solution.status)
    assert status[3] == Status.NOT_FINITE
    for lane in np.flatnonzero(status == Status.CONVERGED):
        assert float(solution.violation[lane]) <= POLISH.tolerance
        assert float(solution.stationarity[lane]) <= POLISH.stationarity
    assert (status == Status.CONVERGED).sum() >= 2


def test_margins_of_a_range_count_from_its_ends():
    """Beside a band a wheel has two ends of one sign."""
    rng = np.random.default_rng(61)
    wheels = reaction_wheels(np.eye(3), 1e-5, 1e-3, 300.0, avoid=[(20.0, 90.0, 0.0)])
    lower, upper = speed_range(wheels, np.array([100.0, 0.0, -100.0]))
    np.testing.assert_array_equal([lower, upper], [[90.0, -20.0, -300.0], [300.0, 20.0, -90.0]])
    ends = SimpleNamespace(speed_lower=jnp.asarray(lower), speed_upper=jnp.asarray(upper))
    speeds = rng.uniform(-400.0, 400.0, (50, 3))
    above, below = (np.asarray(side) for side in range_margins(jnp.asarray(speeds), ends))
    np.testing.assert_allclose(above, (upper - speeds) / np.abs(upper), atol=1e-12)
    np.testing.assert_allclose(below, (speeds - lower) / np.abs(lower), atol=1e-12)
