"""Momentum that wheels can hold."""

import numpy as np
import pytest

from jaxatt.spacecraft.wheels import reaction_wheels, storage_share


def test_the_storage_share_is_that_of_a_linear_programme():
    linprog = pytest.importorskip("scipy.optimize").linprog
    random = np.random.default_rng(3)
    for count in (3, 4, 5, 6):
        axes = random.normal(size=(3, count))
        limit = random.uniform(10.0, 100.0, size=count)
        mounted = reaction_wheels(axes, random.uniform(0.1, 1.0, size=count), 1.0, limit)
        stored = 20.0 * random.normal(size=3)
        # least t with A Jw omega = stored and |omega_j| <= t limit_j
        spun = np.asarray(mounted.axes) * mounted.inertia
        bounds = np.r_[np.zeros(count), 1.0]
        answer = linprog(
            bounds,
            A_eq=np.c_[spun, np.zeros(3)],
            b_eq=stored,
            A_ub=np.block([[np.eye(count), -limit[:, None]], [-np.eye(count), -limit[:, None]]]),
            b_ub=np.zeros(2 * count),
            bounds=[(None, None)] * count + [(0, None)],
        )
        assert storage_share(mounted, stored) == pytest.approx(answer.fun, rel=1e-9)


def test_a_wheel_without_speed_limit_holds_whatever_lies_along_it():
    mounted = reaction_wheels(np.eye(3), 0.1, 1.0, [np.inf, 10.0, 10.0])
    assert storage_share(mounted, [1e6, 0.5, 0.0]) == pytest.approx(0.5)
