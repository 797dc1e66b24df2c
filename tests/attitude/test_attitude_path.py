"""Paths through attitudes and rates, beside an integrated body and finite differences."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from jaxatt.attitude.attitude_path import AttitudePath, through, turn_between

INERTIA = np.diag([0.08, 0.11, 0.04])
TORQUE = np.array([2e-3, -1e-3, 1.5e-3])


def flown(times, seed=0):
    """A body under constant torque, by SciPy: attitudes and rates at the times."""
    drawn = np.random.default_rng(seed)
    q = drawn.normal(size=4)
    start = np.concatenate([q / np.linalg.norm(q), 0.05 * drawn.normal(size=3)])

    def slope(_, x):
        q, omega = x[:4], x[4:]
        turning = 0.5 * np.concatenate([[-q[1:] @ omega], q[0] * omega + np.cross(q[1:], omega)])
        change = np.linalg.solve(INERTIA, TORQUE - np.cross(omega, INERTIA @ omega))
        return np.concatenate([turning, change])

    found = solve_ivp(
        slope, (times[0], times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-13
    ).y.T
    return found[:, :4] / np.linalg.norm(found[:, :4], axis=1, keepdims=True), found[:, 4:]


def apart(a, b):
    """Largest angle between attitudes."""
    turns = Rotation.from_quat(a, scalar_first=True).inv() * Rotation.from_quat(
        b, scalar_first=True
    )
    return turns.magnitude().max()


def test_the_way_between_is_wrong_by_the_fourth_power_of_the_step() -> None:
    fine = np.linspace(0.0, 12.0, 481)
    q, omega = flown(fine)
    wrong, rate_wrong = [], []
    for each in (80, 40, 20):
        path = AttitudePath(fine[::each], q[::each], omega[::each])
        found, rate = path.at(fine)
        wrong.append(apart(found, q))
        rate_wrong.append(np.abs(rate - omega).max())
    assert 1e-9 < wrong[-1] < 1e-5
    assert 12.0 < wrong[0] / wrong[1] < 22.0 and 12.0 < wrong[1] / wrong[2] < 20.0
    assert 6.0 < rate_wrong[1] / rate_wrong[2] < 10.0


def test_it_meets_its_nodes_whatever_their_signs() -> None:
    times = np.cumsum(np.random.default_rng(1).uniform(0.2, 2.0, 20))
    q, omega = flown(times, 1)
    signs = np.random.default_rng(2).choice([-1.0, 1.0], 20)
    found, rate = AttitudePath(times, signs[:, None] * q, omega).at(times)
    assert apart(found, q) < 1e-12
    np.testing.assert_allclose(rate, omega, atol=1e-12)
    found, rate = AttitudePath(times, signs[:, None] * q, omega).at(times - 1e-9)
    assert apart(found[1:], q[1:]) < 1e-8
    np.testing.assert_allclose(rate[1:], omega[1:], atol=1e-7)


@pytest.mark.parametrize("turn", [1e-9, 1e-5, 0.3, 3.0])
def test_rates_are_those_of_the_attitudes(turn) -> None:
    axis = np.array([0.6, -0.48, 0.64])
    q = np.stack([[1.0, 0.0, 0.0, 0.0], [np.cos(turn / 2), *np.sin(turn / 2) * axis]])
    omega = turn * np.array([[0.3, -1.2, 0.2], [0.9, 0.1, -0.8]])
    path = AttitudePath(np.array([0.0, 1.0]), q, omega)
    times, step = np.linspace(0.1, 0.9, 9), 1e-4
    _, rate = path.at(times)
    pairs = np.stack([path.at(times - step)[0], path.at(times + step)[0]])
    moved = np.stack([turn_between(pairs[:, k])[0] for k in range(9)]) / (2.0 * step)
    np.testing.assert_allclose(rate, moved, rtol=1e-5, atol=1e-6 * turn)


def test_rates_that_are_not_given_are_those_of_a_spline_in_body_axes() -> None:
    times = np.linspace(0.0, 12.0, 121)
    q, omega = flown(times)
    path = through(times, q)
    np.testing.assert_allclose(path.omega[5:-5], omega[5:-5], atol=2e-5)
    assert np.abs(omega).max() > 0.05
