"""Manoeuvres that earn energy and point one axis at the end, beside those of fixed rolls."""

import copy
import tomllib
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxatt
from jaxatt import scenarios
from jaxatt.attitude.host_turns import product, turned_by
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.build import manoeuvre_of
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.task import wheels_task

AXIS = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def free():
    document = copy.deepcopy(dict(scenarios.load("hypso1-netpower").document))
    document.pop("printed")
    target = Rotation.from_quat([0.0, 1.0, 0.0, 0.0], scalar_first=True)
    document["target"] = {
        "align": {"body": AXIS.tolist(), "direction_inertial": target.apply(AXIS).tolist()}
    }
    document["horizon"]["intervals"] = 24
    document["solver"]["starts"] = 4
    return jaxatt.solve(scenarios.from_mapping(document))


def fixed(free, roll):
    """Net energy [J] of the same with a fixed roll [rad] from that of the shortest turn."""
    scenario = free.scenario
    near = scenario.targets[0].facing(scenario.initial.q_ob)
    whole = near.facing(product(near.q_ob, turned_by(roll * AXIS)))
    found = jaxatt.solve(replace(scenario, targets=(replace(whole, boresight=None),)))
    assert found.reached
    return found.phases[0].section.energy.net


def test_the_axis_points_where_it_must(free):
    phase, target = free.phases[0], free.scenario.targets[0]
    assert free.reached
    ends = [
        Rotation.from_quat(q, scalar_first=True).apply(AXIS)
        for q in (phase.series["q_ib"][-1], target.q_ob)
    ]
    np.testing.assert_allclose(*ends, atol=2e-4)
    np.testing.assert_allclose(free.summary()["free_roll"]["q_ib"], phase.series["q_ib"][-1])


def test_the_solver_counts_what_the_roll_earns_in_the_last_interval(free):
    section = free.phases[0].section
    assert section.claimed == pytest.approx(section.energy.net, rel=2e-4)


def test_with_a_wheel_failed_as_much_is_earned_as_without_it(free):
    wheels = {
        "vehicle.wheels.axes": [*np.eye(3).tolist(), [0.6, 0.48, 0.64]],
        "vehicle.wheels.failed": ["wheel 4"],
        "initial.wheel_speed_rad_s": [0.0] * 4,
    }
    phase = jaxatt.solve(scenarios.replace(free.scenario, wheels)).phases[0]
    assert phase.reached
    assert phase.section.energy.net == pytest.approx(free.phases[0].section.energy.net, rel=1e-6)


def test_wheel_speeds_at_the_end_are_relative_to_the_body_at_every_roll():
    plan = tomllib.loads(scenarios.text("hypso2-orbit"))
    for name in ("printed", "tasks", "plan", "baseline", "horizon"):
        plan.pop(name, None)
    speeds = [207.0, 211.0, 209.4, -362.0]
    nadir = {"body": AXIS.tolist(), "toward": "nadir"}
    plan |= {
        "magnetorquing": {"mode": "decided"},
        "horizon": {"horizon_s": 300.0, "intervals": 6},
        "target": {"align": nadir, "rate": "orbit", "wheel_speed_rad_s": speeds},
        "objective": {"kind": "net-power", "wheel_power": "wheels"},
    }
    manoeuvre = manoeuvre_of(scenarios.from_mapping(plan), PhaseStart())
    task, craft = wheels_task(manoeuvre), manoeuvre.satellite.craft
    p, wheels = task.parameters, craft.wheels
    for roll in (0.0, 1.3, -2.9):
        q = product(manoeuvre.end.q_ib, turned_by(roll * AXIS))
        rate = manoeuvre.end.facing(q).omega_ib
        axial = wheels.inertia * (np.array(speeds) + wheels.axes.T @ rate)
        momentum = craft.inertia_without_spin @ rate + wheels.axes @ axial
        total = Rotation.from_quat(q, scalar_first=True).apply(momentum)
        x = jnp.concatenate([q, axial / p.momentum_scale, total / p.momentum_scale])
        rows = wheels_programme(task.form).final_rows(x, p)
        assert rows.shape == (3 + 2 + 4,)
        np.testing.assert_allclose(rows, 0.0, atol=1e-12)
    assert np.linalg.norm(rate[:2]) > 5e-4


@pytest.mark.slow
def test_no_fixed_roll_earns_more(free):
    best = free.phases[0].section.energy.net
    own = np.deg2rad(free.summary()["free_roll"]["roll_deg"])
    assert fixed(free, own) == pytest.approx(best, rel=1e-4)
    others = [fixed(free, roll) for roll in np.linspace(0.0, 2.0 * np.pi, 5, endpoint=False)]
    assert max(others) <= best * (1.0 + 1e-5)
    assert min(others) < 0.98 * best
