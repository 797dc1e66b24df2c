"""Sparse slews whose motors lose torque with speed: searched again with less of it."""

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew

SHORT = {"horizon.intervals": 25, "windows": None, "solver.starts": 4, "solver.seed": 3}
NO_TORQUE = 6.0
"""[rad/s] Little more than the speed at which the wheels of this slew turn."""


def solved(**changes):
    given = {**SHORT, **changes}
    result = jaxatt.solve(scenarios.replace(scenarios.load("hypso1-90-45-15"), given))
    return result, result.phases[0].series, result.scenario.vehicle.wheels


def most_beyond(series, wheels):
    """Largest torque of a driving motor beyond its line, as a share of its limit.

    In every interval the speeds run on a line, almost: both its ends are looked at.
    """
    torque, speed = np.asarray(series["torque_wheels"]), np.asarray(series["omega_bw"])
    count = len(torque)
    worst = -1.0
    for end in (speed[:count], speed[1 : count + 1]):
        drives = torque * end > 0.0
        left = 1.0 - np.abs(end) / NO_TORQUE
        beyond = np.abs(torque) / np.asarray(wheels.torque_limit) - left
        worst = max(worst, float(np.where(drives, beyond, -1.0).max()))
    return worst


def test_what_motors_lack_is_found_in_more_or_longer_pulses():
    ideal, series, wheels = solved()
    assert ideal.reached
    assert most_beyond(series, wheels) > 0.03, "the slew has to ask for more than there is"
    weaker, series, wheels = solved(**{"vehicle.wheels.no_torque_speed_rad_s": NO_TORQUE})
    assert weaker.reached
    assert most_beyond(series, wheels) < 1e-6
    assert weaker.summary()["active_intervals"] >= ideal.summary()["active_intervals"]


@pytest.mark.slow
def test_a_motor_without_the_torque_for_any_slew_is_named():
    stuck, _, _ = solved(**{"vehicle.wheels.no_torque_speed_rad_s": 0.5})
    assert not stuck.reached
    assert "motor" in stuck.phases[0].failure_reason


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_a_weaker_task_has_its_limits_scaled_once(share):
    scenario = scenarios.load("hypso1-90-45-15")
    task = build_slew(scenario)
    half = np.full(task.craft.wheels.count, share)
    before = np.asarray(task.arguments.plant.to_wheels)
    after = np.asarray(task.weaker(half).weaker(half).arguments.plant.to_wheels)
    np.testing.assert_allclose(after, before / (1.0 - share), rtol=1e-14)
