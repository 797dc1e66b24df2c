"""Manoeuvres that earn energy and point one axis at the end, beside those of fixed rolls."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxatt
from jaxatt import scenarios
from jaxatt.attitude.host_turns import product, turned_by

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


@pytest.mark.slow
def test_no_fixed_roll_earns_more(free):
    best = free.phases[0].section.energy.net
    own = np.deg2rad(free.summary()["free_roll"]["roll_deg"])
    assert fixed(free, own) == pytest.approx(best, rel=1e-4)
    others = [fixed(free, roll) for roll in np.linspace(0.0, 2.0 * np.pi, 5, endpoint=False)]
    assert max(others) <= best * (1.0 + 1e-5)
    assert min(others) < 0.98 * best
