"""Wheel torques that cancel in the body: within limits, of least square, in few intervals."""

import numpy as np
import pytest
from references.random_vehicles import wheel_axes
from scipy.optimize import minimize

from jaxatt.problems.hands_off.null_torque import null_torque

STEP = 1.4


def drawn(rng, wheels, active, intervals=12, room=0.5):
    axes = wheel_axes(rng, wheels)
    basis = np.linalg.svd(axes)[2][3:].T
    limit = rng.uniform(1e-3, 4e-3, wheels)
    held = np.zeros((intervals, wheels))
    held[active] = rng.uniform(-room, room, (len(active), wheels)) * limit
    return axes, basis, limit, held


@pytest.mark.parametrize("wheels", [4, 5, 6])
def test_torques_cancel_stay_within_limits_and_have_the_impulse(wheels):
    rng = np.random.default_rng(wheels)
    for _ in range(10):
        axes, basis, limit, held = drawn(rng, wheels, [0, 5, 11])
        impulse = 0.6 * STEP * limit.max() * rng.normal(size=wheels - 3)
        order = [k for k in range(12) if not held[k].any()]
        found = null_torque(basis, impulse, held, limit, STEP, order)
        np.testing.assert_allclose(found.torque @ axes.T, 0.0, atol=1e-15)
        assert (np.abs(held + found.torque) <= limit * (1.0 + 1e-9)).all()
        np.testing.assert_allclose(
            STEP * basis.T @ found.torque.sum(axis=0), found.share * impulse, rtol=1e-8
        )
        assert found.share == 1.0


def test_the_square_is_the_least_that_another_solver_finds():
    rng = np.random.default_rng(5)
    binding = 0
    for _ in range(10):
        _, basis, limit, held = drawn(rng, 5, [0, 1, 2, 3], intervals=4, room=0.9)
        impulse = 0.8 * STEP * limit.min() * rng.normal(size=2)
        found = null_torque(basis, impulse, held, limit, STEP, [])
        if found.share < 1.0:
            continue
        total = held + found.torque
        binding += int((np.abs(total) > limit * (1.0 - 1e-6)).any())

        unit = limit.max()

        def added(z, basis=basis, unit=unit):
            return unit * z.reshape(4, 2) @ basis.T

        def left(z, h=held, m=limit, unit=unit):
            return np.r_[(m - h - added(z)).ravel(), (m + h + added(z)).ravel()] / unit

        def missed(z, p=impulse, unit=unit):
            return z.reshape(4, 2).sum(axis=0) - p / (STEP * unit)

        other = minimize(
            lambda z, held=held, unit=unit: np.sum(((held + added(z)) / unit) ** 2),
            np.zeros(8),
            method="SLSQP",
            constraints=[{"type": "ineq", "fun": left}, {"type": "eq", "fun": missed}],
            options={"ftol": 1e-13, "maxiter": 500},
        )
        assert other.success
        assert np.sum((total / unit) ** 2) == pytest.approx(other.fun, rel=1e-7)
    assert binding >= 2


def test_idle_intervals_are_used_in_order_and_only_as_many_as_it_takes():
    rng = np.random.default_rng(8)
    _, basis, limit, held = drawn(rng, 4, [3], room=0.0)
    held[3] = 1e-12
    most = STEP * (limit / np.abs(basis[:, 0])).min()
    order = [2, 4, 1, 5, 0]
    for share, count in ((0.9, 0), (1.5, 1), (2.5, 2), (5.9, 5)):
        found = null_torque(basis, np.array([share * most]), held, limit, STEP, order)
        assert np.flatnonzero(found.added).tolist() == sorted(order[:count])
        assert found.share == 1.0
    short = null_torque(basis, np.array([12.0 * most]), held, limit, STEP, order)
    assert short.share == pytest.approx(0.5)
