"""Verdicts on flights: what misses, what is out of its limits, what the battery lacks."""

import dataclasses

import numpy as np
import pytest
from printed_cases import FIRST, chapter_4, chapter_5
from scipy.spatial.transform import Rotation

from jaxatt.problems.net_power.flight import fly
from jaxatt.problems.net_power.judge import judge_flight, judge_manoeuvre
from jaxatt.spacecraft.speed_bands import speed_bands
from jaxatt.spacecraft.wheel_motor import wheel_motors


def test_errors_are_those_of_the_flown_end():
    task = chapter_5(2, FIRST)
    torque = np.random.default_rng(0).uniform(-1e-3, 1e-3, (2, 20, 4))
    flown = fly(task, torque)
    verdict = judge_manoeuvre(task, torque)
    for k in range(2):
        end = Rotation.from_quat(np.roll(flown.q_ib[k, -1], -1))
        missed = (Rotation.from_quat(np.roll(task.end.q_ib, -1)).inv() * end).magnitude()
        assert verdict.errors["attitude"][k] == pytest.approx(missed, rel=1e-9)
        rate = np.linalg.norm(flown.omega_ib[k, -1] - task.end.omega_ib)
        assert verdict.errors["rate"][k] == pytest.approx(rate)
    assert verdict.tolerances == {"attitude": np.deg2rad(0.1), "rate": 1e-4}
    assert not verdict.reached.any()


def test_a_flight_that_ends_where_it_should_has_reached():
    task = chapter_4()
    torque = np.random.default_rng(1).uniform(-1e-3, 1e-3, (1, 80, 3))
    flown = fly(task, torque)
    end = dataclasses.replace(
        task.end,
        q_ib=-flown.q_ib[0, -1],
        omega_ib=flown.omega_ib[0, -1],
        omega_bw=flown.omega_bw[0, -1],
    )
    there = dataclasses.replace(task, end=end)
    verdict = judge_flight(there, flown)
    assert verdict.reached[0] and set(verdict.errors) == {"attitude", "rate", "wheel speed"}
    away = dataclasses.replace(end, omega_bw=end.omega_bw + np.array([0.0, 0.1, 0.0]))
    assert not judge_flight(dataclasses.replace(task, end=away), flown).reached[0]
    anywhere = judge_flight(dataclasses.replace(task, end=None), flown)
    assert anywhere.reached[0] and not anywhere.errors


def test_torques_and_speeds_beyond_their_limits_are_found():
    task = dataclasses.replace(chapter_4(), end=None)
    torque = np.zeros((2, 80, 3))
    torque[0, 5, 1] = 3.3e-3
    torque[1, :10, 2], torque[1, 10:20, 2] = 3e-3, -3e-3
    verdict = judge_manoeuvre(task, torque)
    assert verdict.limit_violation == pytest.approx([1e-4, 0.0], abs=1e-9)
    # The wheel is fastest in the middle: 5 s at 3 mN m, and the body turns against it.
    fastest = np.abs(fly(task, torque).speeds_passed[1, :, 2]).max()
    assert 3e-3 * 5.0 / 2.1e-4 < fastest < 1.05 * 3e-3 * 5.0 / 2.1e-4
    wheels = dataclasses.replace(
        task.satellite.craft.wheels, speed_limit=np.array([np.inf, np.inf, 0.8 * fastest])
    )
    craft = dataclasses.replace(task.satellite.craft, wheels=wheels)
    slow = dataclasses.replace(task, satellite=dataclasses.replace(task.satellite, craft=craft))
    margin = judge_manoeuvre(slow, torque).margin_violation
    assert margin == pytest.approx([0.0, 0.25], abs=1e-3)


def test_a_battery_below_its_floor_is_found():
    task = dataclasses.replace(chapter_5(1, FIRST), end=None, load=200.0, charge=50e3)
    flown = fly(task, np.zeros((1, 50, 4)))
    least = flown.energy.least_charge[0]
    assert least < 50e3 - 100.0 * 150.0
    held = dataclasses.replace(task, floor=least - 1.0)
    broken = dataclasses.replace(task, floor=least + 3.024)
    assert judge_flight(held, flown).reached[0]
    assert not judge_flight(broken, flown).reached[0]
    # Relative to the capacity of 84 Wh.
    margin = judge_flight(broken, flown).margin_violation[0]
    assert margin == pytest.approx(3.024 / 302400.0, rel=1e-6)


def test_what_is_not_a_number_is_not_reached():
    task = chapter_4()
    torque = np.full((1, 80, 3), np.nan)
    verdict = judge_manoeuvre(task, torque)
    assert not verdict.reached[0] and np.isinf(verdict.errors["attitude"][0])


def with_wheels(task, **changes):
    """The manoeuvre with other wheels."""
    wheels = dataclasses.replace(task.satellite.craft.wheels, **changes)
    craft = dataclasses.replace(task.satellite.craft, wheels=wheels)
    return dataclasses.replace(task, satellite=dataclasses.replace(task.satellite, craft=craft))


def test_motors_pay_for_friction_and_are_judged():
    task = dataclasses.replace(chapter_4(), end=None)
    torque = np.zeros((1, 80, 3))
    torque[0, :10, 2], torque[0, 40:50, 2] = 2e-3, -2e-3
    rubbing = with_wheels(task, motors=wheel_motors(3, coulomb=1e-4, viscous=1e-6))
    free, flown = fly(task, torque), fly(rubbing, torque)
    # What is planned is what acts on wheel and body: the motion is the same.
    np.testing.assert_array_equal(free.omega_bw, flown.omega_bw)
    speed = np.abs(free.omega_bw[0])
    lost = (1e-4 * speed + 1e-6 * speed**2).sum(axis=1)
    lost = np.trapezoid(lost, dx=float(free.step[0]))
    more = float(flown.energy.wheels_J[0] - free.energy.wheels_J[0])
    efficiency = float(np.asarray(task.satellite.craft.wheels.efficiency))
    assert more == pytest.approx(lost / efficiency, rel=2e-3) and more > 1e-2
    assert judge_flight(rubbing, flown).reached[0]
    fast = float(speed.max())
    weak = with_wheels(
        task, motors=wheel_motors(3, full_torque_speed=0.1 * fast, no_torque_speed=fast)
    )
    assert not judge_flight(weak, flown).reached[0]


def test_bands_that_a_manoeuvre_crosses_are_found():
    task = dataclasses.replace(chapter_4(), end=None)
    torque = np.zeros((1, 80, 3))
    torque[0, :10, 2] = 2e-3
    flown = fly(task, torque)
    begins, ends = flown.omega_bw[0, 0, 2], flown.speeds_passed[0, :, 2].max()
    low, high = begins + 0.4 * (ends - begins), begins + 0.6 * (ends - begins)
    # Accelerated evenly for 5 s, the wheel is between the two for one.
    for stay, kept in ((0.0, False), (0.8, False), (1.2, True)):
        banded = with_wheels(task, avoid=speed_bands([(low, high, stay)], 3))
        assert judge_flight(banded, flown).reached[0] == kept
