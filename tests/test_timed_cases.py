"""Turns in minimum time beside printed values and beside CasADi with IPOPT.

The figures of IPOPT are those of `python -m benchmarks.casadi_reorientation CASE`, with --rk4 and
--rho as the key says; it writes the problem down a second time, from the source. More of
them are in the test of the notebook of time and effort.
"""

import functools
import json
import math

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios

IPOPT = {
    ("mrp-k3", 0.01): 28.671300,
    ("mrp-k4", 0.01): 24.212464,
    ("mrp-k4-rk4", 0.01): 24.194868,
    ("mrp-k3-2.5rad", 0.01): 37.440248,
    ("mrp-k4-2.5rad", 0.01): 31.543771,
    ("mrp-k4-rk4", 10.0): 49.459783,
}
"""(scenario, rho) -> final time [s]."""
FAST = [("mrp-k4", 0.01), ("mrp-k4-rk4", 0.01), ("mrp-k4-rk4", 10.0)]


@functools.cache
def solved(name, rho=0.01, starts=4):
    case = scenarios.load(name)
    return jaxatt.solve(scenarios.replace(case, {"objective.effort_weight": rho}), starts=starts)


def case(key):
    return pytest.param(*key, marks=() if key in FAST else pytest.mark.slow)


@pytest.mark.parametrize(("name", "rho"), [case(key) for key in IPOPT])
def test_the_final_time_is_that_of_ipopt(name, rho):
    result = solved(name, rho)
    phase = result.phases[0]
    assert result.reached
    assert phase.final_time == pytest.approx(IPOPT[name, rho], abs=2e-5)
    assert phase.section.cost == pytest.approx(phase.final_time + rho * phase.quadratic_effort)
    assert phase.section.share >= 0.5
    assert max(phase.section.kkt.values()) < 1e-5


def test_the_printed_time_of_four_wheels():
    phase = solved("mrp-k4").phases[0]
    printed = solved("mrp-k4").scenario.printed["time-effort"]
    assert phase.final_time == pytest.approx(printed["final_time_s"], abs=5e-4)
    assert phase.step == pytest.approx(printed["step_s"], abs=5e-5)


@pytest.mark.parametrize("name", ["mrp-k4-rk4", "mrp-k4"])
def test_the_flight_confirms_runge_kutta_and_tells_eulers_error(name):
    phase = solved(name).phases[0]
    off = math.degrees(phase.errors["attitude"])
    assert phase.section.own_error < 1e-6
    if name.endswith("rk4"):
        assert off < 1e-3
    else:
        assert 0.02 < off < 0.5


def test_without_saturation_the_effort_is_cheap_and_there_are_no_switches():
    phase = solved("mrp-k4-rk4", 10.0).phases[0]
    assert np.abs(phase.series["torque_wheels"]).max() < 0.5
    assert all(times.size == 0 for times in phase.section.switch_times)


@pytest.mark.slow
def test_quaternions_and_mrp_are_the_same_turn():
    case = scenarios.load("mrp-k4-rk4")
    other = scenarios.replace(case, {"transcription.attitude": "mrp"})
    found = jaxatt.solve(other, starts=4).phases[0]
    assert found.final_time == pytest.approx(solved("mrp-k4-rk4").phases[0].final_time, abs=1e-3)


def test_a_turn_to_where_one_is_takes_no_time():
    case = scenarios.replace(scenarios.load("mrp-k4-rk4"), {"target.attitude_mrp": [0, 0, 0]})
    result = jaxatt.solve(case, starts=4)
    assert result.reached
    assert result.phases[0].final_time < 1e-3
    assert result.phases[0].quadratic_effort < 1e-3


def test_the_summary_is_json(tmp_path):
    found = json.loads(json.dumps(solved("mrp-k4").summary()))
    assert found["final_time_s"] == pytest.approx(24.2125, abs=1e-3)
    assert found["starts"]["requested"] == 4
