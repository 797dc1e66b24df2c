"""Motors of wheels: friction, torque over speed, and wheels that run down, against formulas."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.problems.motor_torques import broken_motors, motor_excess, motor_torque
from jaxatt.simulation.wheeled_body import wheeled_body
from jaxatt.spacecraft import create, reaction_wheels
from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.wheel_motor import friction, torque_range, wheel_motors

INERTIA = 2e-4


def wheels_with(**motors):
    return reaction_wheels(np.eye(3), INERTIA, 3e-3, motors=motors)


def test_the_limit_is_whole_then_a_line_and_whole_again_for_braking():
    rng = np.random.default_rng(4)
    full, none = rng.uniform(50.0, 100.0), rng.uniform(200.0, 300.0)
    motors = wheel_motors(3, full_torque_speed=full, no_torque_speed=none)
    speeds = rng.uniform(-400.0, 400.0, (200, 3))
    least, most = torque_range(motors, speeds)
    np.testing.assert_allclose(most, np.interp(speeds, [full, none], [1.0, 0.0]), atol=1e-12)
    np.testing.assert_allclose(least, -np.interp(-speeds, [full, none], [1.0, 0.0]), atol=1e-12)
    for part in torque_range(wheel_motors(3), speeds):
        assert (np.abs(part) == 1.0).all()


def test_friction_is_odd_and_known_far_from_rest():
    rng = np.random.default_rng(5)
    motors = wheel_motors(3, coulomb=[1e-4, 2e-4, 0.0], viscous=1e-6)
    speeds = rng.uniform(20.0, 500.0, (50, 3))
    expected = np.array([1e-4, 2e-4, 0.0]) + 1e-6 * speeds
    np.testing.assert_allclose(friction(motors, speeds), expected, rtol=1e-12)
    np.testing.assert_allclose(friction(motors, -speeds), -expected, rtol=1e-12)


def run_down(wheels, speed, motor, period, samples):
    """Speeds (samples + 1, 3) of wheels on a body that does not move."""
    body = wheeled_body(create(np.diag([1e3, 1e3, 1e3]), wheels))

    @jax.jit
    def left(speeds):
        taken = body.after_friction(
            tuple(jnp.asarray(motor, float)), tuple(speeds), jnp.asarray(period)
        )
        return jnp.stack(taken)

    speeds = [np.asarray(speed, float)]
    for _ in range(samples):
        speeds.append(speeds[-1] + period * np.asarray(left(speeds[-1])) / INERTIA)
    return np.array(speeds)


def test_viscous_friction_slows_a_free_wheel_exponentially():
    viscous, period = np.array([1e-5, 3e-5, 0.0]), 0.5
    found = run_down(wheels_with(viscous=viscous), [100.0, -80.0, 60.0], np.zeros(3), period, 100)
    times = period * np.arange(101.0)[:, None]
    exact = np.array([100.0, -80.0, 60.0]) * np.exp(-viscous * times / INERTIA)
    np.testing.assert_allclose(found, exact, rtol=1e-10)


def test_dry_friction_stops_a_free_wheel_in_finite_time_and_holds_it():
    coulomb, period = 1e-4, 0.5
    begins = np.array([10.0, -7.3, 0.0])
    found = run_down(wheels_with(coulomb=coulomb), begins, np.zeros(3), period, 60)
    times = period * np.arange(61.0)[:, None]
    left = np.maximum(np.abs(begins) - coulomb / INERTIA * times, 0.0)
    np.testing.assert_allclose(found, np.sign(begins) * left, atol=1e-10)
    # A motor that is weaker than friction does not move a wheel; a stronger one does.
    pushed = run_down(wheels_with(coulomb=coulomb), np.zeros(3), [0.9e-4, -0.9e-4, 3e-4], 0.5, 60)
    np.testing.assert_allclose(pushed[:, :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(pushed[:, 2], 2e-4 / INERTIA * times[:, 0], rtol=1e-10)


def test_both_frictions_together_converge_to_the_formula():
    coulomb, viscous, begins = 1e-4, 1e-5, 100.0
    speeds = []
    for period in (0.2, 0.1, 0.05):
        wheels = wheels_with(coulomb=coulomb, viscous=viscous)
        speeds.append(run_down(wheels, [begins] * 3, np.zeros(3), period, round(20.0 / period)))
    exact = (begins + coulomb / viscous) * np.exp(-viscous * 20.0 / INERTIA) - coulomb / viscous
    errors = [abs(found[-1, 0] - exact) for found in speeds]
    assert errors[2] < 0.06 * exact / 20.0 and errors[0] > 1.8 * errors[1] > 3.2 * errors[2]


def test_motors_give_friction_too_and_are_named_where_they_cannot():
    wheels = wheels_with(coulomb=2e-4, full_torque_speed=50.0, no_torque_speed=100.0)
    speeds = np.array([[0.0, 60.0, -60.0], [0.0, 75.0, -60.0], [0.0, 75.0, -60.0]])
    torque = np.array([[0.0, 2e-3, 2e-3], [0.0, 1e-3, -2.3e-3]])
    given = motor_torque(wheels, torque, speeds)
    np.testing.assert_allclose(given[:, 1:], torque[:, 1:] + [2e-4, -2e-4], rtol=1e-9)
    excess = motor_excess(wheels, torque[None], speeds[None])[0]
    # At 75 rad/s half of 3 mN m is left, at 60 rad/s four fifths.
    np.testing.assert_allclose(excess[1:], [2.2 / 3.0 - 0.5, 2.5 / 3.0 - 0.8], rtol=1e-6)
    words = broken_motors(wheels, torque, speeds)
    assert [word[:21] for word in words] == ["the motor of wheel 2 ", "the motor of wheel 3 "]
    assert (motor_excess(wheels_with(), torque[None], speeds[None]) == -1.0).all()


@pytest.mark.parametrize(
    ("motors", "words"),
    [
        ({"coulomb": -1e-4}, "at least 0"),
        ({"viscous": [1e-6, 1e-6]}, "give one number for all or 3"),
        ({"full_torque_speed": 50.0}, "no torque is left"),
        ({"full_torque_speed": 50.0, "no_torque_speed": 40.0}, "give a higher speed"),
    ],
)
def test_motors_that_make_no_sense_are_refused(motors, words):
    with pytest.raises(FieldError, match=words):
        wheels_with(**motors)
