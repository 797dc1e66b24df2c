"""A slew with thrusters between two cones, flown again by SciPy."""

import numpy as np
from references import wheeled_body
from scipy.integrate import solve_ivp

import jaxatt
from jaxatt import scenarios

PIECES = 12


def fly(scenario, thrust, step):
    """Euler's equations from the scenario's start under thruster torques (N, m): R_ib and rates."""
    craft = scenario.vehicle
    inertia, mounting = np.asarray(craft.inertia), np.asarray(craft.thrusters.distribution)
    state = np.concatenate([scenario.initial.q_ob, scenario.initial.omega_ob])
    samples = [state]
    for row in thrust:
        torque = mounting @ row

        def rates(_, x, torque=torque):
            q, w = x[:4], x[4:]
            turn = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
            return np.concatenate(
                [turn, np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))]
            )

        times = np.linspace(0.0, step, PIECES + 1)
        done = solve_ivp(
            rates, (0.0, step), samples[-1], t_eval=times, method="DOP853", rtol=1e-12, atol=1e-12
        )
        samples += list(done.y.T[1:])
    samples = np.array(samples)
    q = samples[:, :4] / np.linalg.norm(samples[:, :4], axis=1, keepdims=True)
    return np.array([wheeled_body.rotation(each) for each in q]), samples[:, 4:]


def test_thrusters_turn_past_sun_and_moon():
    scenario = scenarios.replace(
        scenarios.load("eseo-1-keep-out"),
        {"solver.starts": 4, "horizon.coast_intervals": 2, "horizon.intervals": 45},
    )
    result = jaxatt.solve(scenario)
    phase = result.phases[0]
    assert result.reached, phase.failure_reason
    assert 5 <= result.active_intervals <= 14
    turned, rates = fly(scenario, phase.series["torque_thrusters"], phase.step)
    target = wheeled_body.rotation(scenario.targets[0].q_ob)
    assert np.linalg.norm(turned[-1] - target) < 1e-3 and np.linalg.norm(rates[-1]) < 1e-4
    directions = scenario.pointing.directions(np.zeros(1))[0]
    cones, told = scenario.pointing.cones, result.summary()["pointing"]
    for cone, direction, found in zip(cones, directions, told, strict=True):
        angle = np.arccos(np.clip(turned @ cone.boresight @ direction, -1.0, 1.0))
        assert angle.min() >= cone.half_angle * (1 - 2e-6)
        np.testing.assert_allclose(found["nearest_deg"], np.rad2deg(angle.min()), atol=0.05)
    # Valves that are open or shut are judged against the cones as well.
    valves = phase.section.quantised[0]
    assert valves.reached == (not valves.failure_reason)
