"""Plans that cannot be flown are refused before anything is solved, and say which task and why."""

import dataclasses
import math

import numpy as np
import pytest

from jaxatt.environment.light import Light
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.plan.floor import best_charge, check_floor
from jaxatt.problems.net_power.plan.modes import COMMUNICATE, HARVEST
from jaxatt.problems.net_power.plan.reach import check_reach, farthest_turn
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.vehicles import load_vehicle
from jaxatt.spacecraft import create, reaction_wheels

CRAFT = load_vehicle("hypso2")
SUN = np.array([0.0, 1.0, 0.0])  # on +y of a body that lies along the inertial axes
STILL = np.zeros(3)
UPRIGHT = Pose(np.array([1.0, 0.0, 0.0, 0.0]), STILL)
TURNED = Pose(np.array([0.0, 1.0, 0.0, 0.0]), STILL)


def satellite(charge):
    """Alone with the sun; the charge is a share of the capacity."""
    battery = dataclasses.replace(CRAFT.battery, charge=charge * CRAFT.battery.capacity)
    return Satellite(dataclasses.replace(CRAFT, battery=battery), Light(1361.0, SUN))


def tasks(seconds, load=40.0, pose=TURNED):
    return (
        Task("before", HARVEST, 0.0, 100.0, 50, load=13.5),
        Task("a long pass", COMMUNICATE, 100.0, seconds, 50, pose, load=load),
    )


def test_the_best_charge_is_the_sum_of_powers_by_hand():
    """Panels on +y face the sun (upright) or -y do (turned by half a turn about x)."""
    harvest, held = tasks(200.0)
    around = satellite(0.5)
    start = 0.5 * CRAFT.battery.capacity
    power = 1361.0 * 0.2 * 0.92
    _, charge = best_charge(harvest, around, start)
    assert charge[-1] - start == pytest.approx(100.0 * (0.144 * power - 13.5), rel=1e-9)
    _, charge = best_charge(held, around, start)
    assert charge[-1] - start == pytest.approx(200.0 * (0.048 * power - 40.0), rel=1e-9)
    _, charge = best_charge(harvest, around, CRAFT.battery.capacity)
    np.testing.assert_allclose(charge, CRAFT.battery.capacity)


def test_floor_that_cannot_hold():
    """84 Wh half full: 42 Wh, of which the pass draws 28 W for an hour and a half."""
    around, floor = satellite(0.5), 0.1 * CRAFT.battery.capacity
    check_floor(tasks(3000.0), around, floor, "test", None)
    with pytest.raises(ScenarioError) as error:
        check_floor(tasks(5400.0), around, floor, "test", None)
    message = str(error.value)
    assert 'no. 2 "a long pass": the battery cannot stay above its floor of 8.4 Wh' in message
    power = 1361.0 * 0.2 * 0.92
    left = 42.0 + (100.0 * (0.144 * power - 13.5) + 5400.0 * (0.048 * power - 40.0)) / 3600.0
    assert f"it holds {left:.4g} Wh at 5500 s, {8.4 - left:.3g} Wh too little" in message


def test_farthest_turn_is_sharp_for_one_axis():
    """A symmetric body about one of its axes: the bound is a^2 t / 4, with all wheels at work."""
    craft = create(np.eye(3), reaction_wheels(np.eye(3), 1e-9, 1.0))
    # Along the diagonal the wheels give sqrt(3) times the torque of one.
    expected = math.sqrt(3.0) * 9.0 / 4.0
    assert farthest_turn(craft, STILL, STILL, 3.0) == pytest.approx(1.02 * expected, rel=1e-6)
    moving = np.array([0.5, 0.0, 0.0])
    assert farthest_turn(craft, moving, moving, 3.0) == pytest.approx(
        1.02 * expected + 1.5, rel=1e-6
    )
    assert farthest_turn(craft, 10.0 * moving, STILL, 1.0) == 0.0


def test_turn_that_takes_longer_than_the_harvest():
    short = dataclasses.replace(tasks(60.0)[0], duration=6.0)
    with pytest.raises(ScenarioError) as error:
        check_reach((short, tasks(60.0)[1]), CRAFT, UPRIGHT, "test")
    message = str(error.value)
    assert 'no. 2 "a long pass": cannot be reached: the turn to it takes 180 deg' in message
    assert 'in the 6 s of "before" the wheels turn the body by at most' in message
    check_reach(tasks(60.0), CRAFT, UPRIGHT, "test")
    check_reach((short, tasks(60.0)[1]), CRAFT, None, "test")
