"""Steps an interval from measured errors, beside SciPy's error control."""

import numpy as np
import scipy.integrate
from references import random_vehicles

from jaxatt.simulation.step_error import _ended, steps_needed


def flown(inertia, rate, momentum, duration):
    """Attitude and rate after a motion without torque, under error control."""

    def slope(_, y):
        q, w, spin = y[:4], y[4:7], y[7:]
        turned = -np.cross(w, spin)
        turning = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([turning, np.linalg.solve(inertia, turned), turned])

    begin = np.concatenate([[1.0, 0.0, 0.0, 0.0], rate, momentum])
    ended = scipy.integrate.solve_ivp(
        slope, (0.0, duration), begin, method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    return ended[:4] / np.linalg.norm(ended[:4]), ended[4:7]


def test_the_steps_that_are_asked_for_hold_the_tolerance_and_half_of_them_would_not():
    rng = np.random.default_rng(31)
    asked = []
    for _ in range(12):
        inertia = random_vehicles.inertia(rng)
        step, intervals = 2.0, 15
        rate = 0.05 * rng.normal(size=3)
        nutation = 10.0 ** rng.uniform(-1.5, 0.3) * rng.normal(size=3)
        momentum = inertia @ (rate + nutation)
        within = (1e-4, 1e-4)
        steps = steps_needed(inertia, rate[None], momentum[None], step, intervals, within)
        exact = flown(inertia, rate, momentum, step * intervals)
        begin = np.concatenate([[1.0, 0.0, 0.0, 0.0], rate, momentum])[None]

        def off(steps, begin=begin, inertia=inertia, exact=exact):
            y = _ended(begin, np.linalg.inv(inertia), 2.0, 15, steps)[0]
            angle = 2.0 * np.arccos(min(1.0, abs(y[:4] @ exact[0])))
            return max(angle, np.linalg.norm(y[4:7] - exact[1])) / 1e-4

        assert off(steps) < 1.2
        assert steps == 1 or off(max(1, steps // 2)) > 1.0
        asked.append(steps)
    assert min(asked) < 4 and max(asked) > 8


def test_a_body_at_rest_needs_one_step_in_any_units():
    for scale in (1e-6, 1.0, 1e6):
        inertia = scale * np.diag([0.07, 0.05, 0.03])
        rate = np.array([[0.0, 0.0, 0.0], [0.02, 0.01, -0.01]])
        assert steps_needed(inertia, rate, np.zeros((2, 3)), 1.4, 50, (1e-4, 1e-5)) == 1


def test_there_is_a_most():
    inertia, rate = np.diag([0.07, 0.05, 0.03]), np.array([[0.01, 0.0, 0.0]])
    momentum = np.array([[0.0, 0.0, 1e3]])
    assert steps_needed(inertia, rate, momentum, 100.0, 50, (1e-4, 1e-5)) == 128
