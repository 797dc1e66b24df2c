"""Differential correction of torques whose flight begins elsewhere than they were found for."""

from dataclasses import replace

import numpy as np
import pytest

import jaxatt
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import phase_manoeuvre
from jaxatt.problems.net_power.corrected import corrected
from jaxatt.problems.net_power.judge import judge_manoeuvre


@pytest.fixture(scope="module")
def found():
    result = jaxatt.solve("hypso1-netpower", starts=2)
    return phase_manoeuvre(result.scenario, PhaseStart()), result.phases[0].controls


@pytest.mark.parametrize("seed", [3, 4])
def test_a_disturbed_start_ends_where_it_is_asked_to(found, seed):
    manoeuvre, torque = found
    push = 3e-4 * np.random.default_rng(seed).normal(size=3)
    start = replace(manoeuvre.start, omega_ib=manoeuvre.start.omega_ib + push)
    disturbed = replace(manoeuvre, start=start)
    limit = np.asarray(manoeuvre.satellite.craft.wheels.torque_limit)
    before = judge_manoeuvre(disturbed, torque[None])
    mended = corrected(disturbed, torque)
    after = judge_manoeuvre(disturbed, mended[None])
    assert not before.reached[0]
    assert after.reached[0]
    assert after.errors["attitude"][0] < 0.1 * after.tolerances["attitude"]
    assert np.abs(mended).max() <= limit.max()
    assert np.abs(mended - torque).max() < 0.05 * limit.max()


def test_what_arrives_stays_as_it_is(found):
    manoeuvre, torque = found
    np.testing.assert_array_equal(corrected(manoeuvre, torque), torque)
    open_ended = replace(manoeuvre, end=None)
    np.testing.assert_array_equal(corrected(open_ended, torque), torque)


def test_a_long_hold_is_corrected_for_a_tiny_rate(found):
    manoeuvre, _ = found
    hold = replace(
        manoeuvre,
        end=replace(manoeuvre.end, q_ib=manoeuvre.start.q_ib),
        duration=4000.0,
        intervals=400,
    )
    start = replace(hold.start, omega_ib=np.array([2e-6, -3e-6, 1e-6]))
    drifting, still = replace(hold, start=start), np.zeros((400, 3))
    assert not judge_manoeuvre(drifting, still[None]).reached[0]
    assert judge_manoeuvre(drifting, corrected(drifting, still)[None]).reached[0]
