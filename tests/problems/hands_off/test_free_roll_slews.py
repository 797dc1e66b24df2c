"""Sparse slews that point one axis: derivatives, and answers beside those of fixed rolls."""

import copy
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.attitude import quaternion
from jaxatt.attitude.free_roll import across, roll_angle
from jaxatt.attitude.host_turns import product, turned_by
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.enumeration import try_supports
from jaxatt.problems.hands_off.search.polish import SETTLED, Method
from jaxatt.problems.hands_off.slew.model import fly_nodes, terminal_rows
from jaxatt.problems.hands_off.slew.pulse_equations import pulse_equations
from jaxatt.problems.hands_off.slew.response import response_rows, slew_response
from jaxatt.problems.hands_off.slew.thruster_response import (
    fly_thrusters,
    thruster_response,
    thruster_rows,
)
from jaxatt.runtime.settings import RUNS_ONCE

AXIS = np.array([0.6, 0.8, 0.0])


def pointed(name, **changes):
    """A bundled slew that points an axis where its own target has it, at 12 intervals."""
    scenario = scenarios.load(name)
    document = copy.deepcopy(dict(scenario.document))
    for key in [key for key in document["target"] if "tolerance" not in key]:
        document["target"].pop(key)
    axes = "direction_inertial" if scenario.orbit is None else "direction_orbit"
    direction = np.asarray(quaternion.rotate(scenario.targets[0].q_ob, AXIS))
    document["target"]["align"] = {"body": AXIS.tolist(), axes: direction.tolist()}
    document.pop("printed", None)
    document.pop("windows", None)
    for key, value in changes.items():
        document[key] = {**document.get(key, {}), **value}
    return scenarios.from_mapping(document)


def aimed(p, end):
    """The same slew, whose end has the boresight where it must be, at another roll."""
    orbit = p.table.nodes.orbit_attitude[-1]
    q = quaternion.multiply(quaternion.conjugate(orbit), jnp.stack(end[:4]))
    boresight = np.cross(*np.asarray(p.held))
    return replace(p, reference=quaternion.multiply(q, turned_by(2.0 * boresight)))


def test_what_pulses_do_to_the_boresight_is_nearly_exact_at_the_target():
    task = build_slew(pointed("hypso1-path"))
    rng = np.random.default_rng(4)
    u = jnp.asarray(0.02 * rng.normal(size=(task.intervals, task.size)))
    p, form = (
        aimed(task.arguments.plant, fly_nodes(u, task.arguments.plant, task.form)[0]),
        task.form,
    )

    @jax.jit
    def both(u, p):
        found = pulse_equations(u, jnp.ones_like(u), u, jnp.asarray(True), p, form)
        pulled = jax.vmap(found.pullback)(jnp.eye(len(found.rows)))
        rows, slopes = slew_response(u, p, form)
        automatic = jax.jacrev(response_rows)(u, p, form)
        return found.rows, found.matrix, found.reached, pulled, rows, slopes, automatic

    rows, matrix, reached, pulled, same, slopes, automatic = (np.asarray(x) for x in both(u, p))
    assert rows.shape == (8,) and np.abs(rows[:2]).max() < 1e-9
    np.testing.assert_allclose(rows, same, atol=1e-12)
    np.testing.assert_allclose(np.swapaxes(slopes, 0, 1), automatic, atol=1e-9)
    for block in (slice(0, 2), slice(2, 5)):
        want = automatic[block]
        np.testing.assert_allclose(pulled[block], want, atol=0.1 * np.abs(want).max())
    flat = pulled.reshape(8, -1)
    # The sums are taken in single precision.
    np.testing.assert_allclose(matrix, flat @ flat.T, atol=1e-6 * np.abs(matrix).max())
    terms = flat * np.asarray(u).ravel()
    np.testing.assert_allclose(
        reached, terms.sum(axis=1), atol=1e-6 * np.abs(terms).sum(axis=1).max()
    )


def test_what_thrusters_do_to_the_boresight_is_nearly_exact_at_the_target():
    task = build_slew(pointed("eseo-3", horizon={"intervals": 12, "horizon_s": 8.0}))
    rng = np.random.default_rng(5)
    u = jnp.asarray(rng.uniform(task.mounting.lower, task.mounting.upper, (12, task.size)))
    plant, form = task.arguments.plant, task.form
    p = aimed(plant, fly_thrusters(u, plant, form)[0])
    rows, found = jax.jit(lambda u: thruster_response(u, p, form))(u)
    exact = np.swapaxes(jax.jit(jax.jacrev(lambda u: thruster_rows(u, p, form)))(u), 0, 1)
    assert rows.shape == (5,) and np.abs(rows[:2]).max() < 1e-9
    scale = np.abs(exact).max(axis=(0, 2))
    assert (np.abs(found - exact).max(axis=(0, 2)) < 5e-3 * scale).all()


@pytest.fixture(scope="module")
def free():
    horizon, solver = {"intervals": 20, "coast_intervals": 0}, {"starts": 12}
    return jaxatt.solve(pointed("hypso1-90-45-15", horizon=horizon, solver=solver))


def test_the_answer_points_the_axis_and_says_its_roll(free):
    phase, target = free.phases[0], free.scenario.targets[0]
    assert free.reached and phase.active_intervals == 2
    end = phase.series["q_ob"][20]
    wanted, found = (np.asarray(quaternion.rotate(q, AXIS)) for q in (target.q_ob, end))
    assert np.arccos(np.clip(wanted @ found, -1.0, 1.0)) < 1e-5
    told = free.summary()["free_roll"]
    near = target.facing(free.scenario.initial.q_ob).q_ob
    assert told["roll_deg"] == pytest.approx(np.rad2deg(float(roll_angle(near, AXIS, end))))
    np.testing.assert_allclose(told["q_ob"], end)


def test_the_support_of_an_answer_is_found_again_from_rest(free):
    # As certificates do it; the roll, too, has to settle.
    task = build_slew(free.scenario).sharing_programs()
    pairs = np.array([[[0, 0], [19, 0]], [[3, 0], [12, 0]]])
    u, residual, _ = try_supports(task, pairs, 1.0, Method("l0", rows=12))
    assert (residual <= SETTLED).all()
    effort = task.l1_effort(task.to_controls(u))
    assert free.phases[0].l1_effort == pytest.approx(effort[0], rel=0.1)
    assert free.phases[0].l1_effort < effort.min() < effort[1]


@pytest.mark.slow
def test_a_roll_moves_until_a_cone_is_grazed(free):
    axis = np.array([0.0, 0.0, 1.0])
    path = np.asarray(quaternion.rotate(free.phases[0].series["q_ob"][:21], axis))
    cone = {"name": "sun", "boresight": axis.tolist(), "half_angle_deg": 3.0}
    cone["direction_orbit"] = path[10].tolist()
    document = {**free.scenario.document, "keep_out": [cone]}
    beside = jaxatt.solve(scenarios.from_mapping(document))
    found, way = beside.phases[0], free.phases[0]
    assert found.reached and found.active_intervals == way.active_intervals
    assert way.l1_effort < found.l1_effort < 1.005 * way.l1_effort
    # What is left to the cone is the allowance for the way between two nodes.
    assert 3.0 - 1e-5 <= beside.summary()["pointing"][0]["nearest_deg"] < 3.1


def test_no_fixed_roll_takes_less(free):
    scenario, best = free.scenario, free.phases[0]
    near = scenario.targets[0].facing(scenario.initial.q_ob)
    own = np.deg2rad(free.summary()["free_roll"]["roll_deg"])
    efforts = []
    for roll in (own, own + 0.05, own - 0.05, 0.0, 2.0, 4.0):
        whole = near.facing(product(near.q_ob, turned_by(roll * AXIS)))
        fixed = replace(scenario, targets=(replace(whole, boresight=None),))
        found = jaxatt.solve(fixed).phases[0]
        assert found.reached
        assert found.active_intervals >= best.active_intervals
        efforts.append(found.l1_effort if found.active_intervals == 2 else np.inf)
    assert efforts[0] == pytest.approx(best.l1_effort, rel=1e-4)
    assert best.l1_effort <= min(efforts) * (1.0 + 1e-5)
    assert max(efforts[3:]) > 1.05 * best.l1_effort


@pytest.mark.parametrize(
    "target", [{"wheel_bias_rad_s": 50.0}, {"rate": "inertial"}], ids=["bias", "inertial"]
)
def test_the_roll_stays_free_beside_what_else_is_asked_for(free, target):
    result = jaxatt.solve(scenarios.replace(free.scenario, _keys(target)))
    phase, best = result.phases[0], free.phases[0]
    assert result.reached and phase.active_intervals == best.active_intervals
    same = result.summary()["free_roll"]["roll_deg"] == pytest.approx(
        free.summary()["free_roll"]["roll_deg"], abs=1e-6
    )
    # Torques that cancel in the body move no roll; another rate at the end does.
    assert same == ("rate" not in target)
    if same:
        assert phase.l1_effort == pytest.approx(best.l1_effort, rel=1e-9)


def _keys(target):
    return {f"target.{key}": value for key, value in target.items()}


def test_rows_of_a_task_are_those_of_its_flight():
    task = build_slew(pointed("hypso1-90-45-15", horizon={"intervals": 12}))
    u = 0.02 * np.random.default_rng(6).normal(size=(12, task.size))
    rows = jax.jit(terminal_rows, static_argnums=2, compiler_options=RUNS_ONCE)
    found = np.asarray(rows(jnp.asarray(u), task.arguments.plant, task.form))
    errors = task.verify((u * task.scale)[None])[0].errors
    angle = 4.0 * np.arcsin(np.linalg.norm(found[:2]) / 4.0)
    assert angle == pytest.approx(errors["attitude"][0], abs=1e-5)
    assert np.linalg.norm(found[2:]) / 10.0 == pytest.approx(errors["rate"][0], abs=1e-6)
    np.testing.assert_allclose(task.arguments.plant.held, across(AXIS))
