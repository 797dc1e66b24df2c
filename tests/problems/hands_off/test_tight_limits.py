"""Sparse slews whose torque limits bind: bursts at both ends, whatever the axes and the way."""

import functools
import tomllib

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios

INERTIA = np.array([[0.0775, 0.0002, -0.0002], [0.0002, 0.1067, 0.0005], [-0.0002, 0.0005, 0.0389]])
AXES = np.vstack([np.eye(3), np.full(3, 3.0**-0.5)])


def euler(phi, theta, psi):
    """Quaternion of Rz(psi) Ry(theta) Rx(phi) [deg]."""
    half = np.radians([phi, theta, psi]) / 2.0
    (a, b, c), (s, t, u) = np.cos(half), np.sin(half)
    return np.array(
        [
            a * b * c + s * t * u,
            s * b * c - a * t * u,
            a * t * c + s * b * u,
            a * b * u - s * t * c,
        ]
    )


def product(p, q):
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.array([w, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


@functools.cache
def active(limit, target, *, cyclic=False, back=False):
    """Active intervals of a slew from rest to rest with wheels of this torque limit [N m]."""
    begin, end = np.array([1.0, 0.0, 0.0, 0.0]), euler(*target)
    inertia, axes = INERTIA, AXES
    if back:
        begin, end = end, begin
    if cyclic:
        # Body axes named anew: y is what was x.
        order = [2, 0, 1]
        inertia, axes = INERTIA[np.ix_(order, order)], AXES[:, order]
        anew = np.array([0.5, -0.5, -0.5, -0.5])
        begin, end = product(begin, anew), product(end, anew)
    rows = "\n".join(f"    {list(map(float, axis))}," for axis in axes)
    document = tomllib.loads(
        f"""
name = "case"
title = "Slew"
[vehicle]
name = "body"
inertia_kgm2 = {inertia.tolist()}
[vehicle.wheels]
axes = [
{rows}
]
inertia_kgm2 = 2.1e-4
torque_limit_Nm = {limit}
[orbit]
semi_major_axis_km = 6852.2
eccentricity = 0.002
inclination_deg = 97.0
raan_deg = 280.0
argument_of_periapsis_deg = 0.0
true_anomaly_deg = 0.0
[initial]
attitude_quaternion = {begin.tolist()}
[target]
attitude_quaternion = {end.tolist()}
attitude_tolerance_deg = 0.01
rate_tolerance_rad_s = 1e-5
[horizon]
horizon_s = 70.0
intervals = 50
[objective]
kind = "l0"
[solver]
starts = 8
"""
    )
    result = jaxatt.solve(scenarios.from_mapping(document))
    assert result.reached
    return np.flatnonzero(result.phases[0].active)


TARGET = (90.0, 45.0, 15.0)


@pytest.mark.parametrize("other", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_bursts_at_both_ends_whatever_the_axes_and_the_way(other):
    # Of two bursts alone, [0, 1, 2, 47, 48, 49], six intervals are the fewest.
    found = active(3.75e-4, TARGET, cyclic=other, back=other)
    assert len(found) == 5 and {0, 1, 48, 49} < set(found)


def test_weaker_wheels_need_no_fewer_intervals():
    weak, strong = (active(limit, TARGET, cyclic=True, back=True) for limit in (3.75e-4, 1.5e-3))
    assert len(strong) <= len(weak)
