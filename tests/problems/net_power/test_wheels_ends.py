"""Ends and limits of manoeuvres with wheels, solved: a soft end, an imaging rate, wheel speeds,
a battery's floor, dipoles that are decided."""

import copy
import tomllib

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.problems.net_power.record import net_power

pytestmark = [pytest.mark.slow, pytest.mark.optimised]

TURN = tomllib.loads(scenarios.text("hypso1-netpower"))
PLAN = tomllib.loads(scenarios.text("hypso2-orbit"))


def solved(starts, **tables):
    document = copy.deepcopy(TURN)
    document.pop("printed")
    for name, table in tables.items():
        document[name] = {**document.get(name, {}), **table}
    return jaxatt.solve(scenarios.from_mapping(document), starts=starts)


def test_a_soft_end_earns_a_little_more_and_is_off_the_target():
    """The printed cost (3.5) with the weights of table 4.1."""
    weights = {"terminal": "penalty", "attitude_weight_J": 3.75e4, "rate_weight_J_s2": 3.75e6}
    (phase,) = solved(16, objective=weights, target={"attitude_tolerance_deg": 1.0}).phases
    found = net_power(phase)
    assert found.energy.net == pytest.approx(573.58, abs=0.03)
    assert 0.05 < np.degrees(phase.errors["attitude"]) < 0.3
    attitude, rate = phase.errors["attitude"], phase.errors["rate"]
    missed = 3.75e4 * (1.0 - np.cos(0.5 * attitude)) + 3.75e6 * rate**2
    assert found.cost == pytest.approx(missed - found.energy.net, abs=1e-6)


def test_an_imaging_rate_is_ended_with():
    rate = np.radians([0.0, -0.754, 0.0])
    (phase,) = solved(8, target={"rate_rad_s": rate.tolist()}).phases
    assert phase.reached
    np.testing.assert_allclose(phase.series["omega_ib"][-1], rate, atol=1e-5)


def test_decided_dipoles_bring_the_wheels_to_the_speeds_that_are_wanted():
    """Speeds at the end take momentum away, which only a torque from outside can do."""
    document = {name: copy.deepcopy(PLAN[name]) for name in PLAN}
    for name in ("printed", "tasks", "plan", "baseline", "horizon"):
        document.pop(name, None)
    wanted = [207.0, 211.0, 209.4, -362.0]
    document |= {
        "magnetorquing": {"mode": "decided"},
        "initial": {**document["initial"], "rate_rad_s": [0.0] * 3},
        "horizon": {"horizon_s": 300.0, "intervals": 60},
        "target": {
            "attitude_quaternion": [0.853, 0.372, -0.019, -0.366],
            "wheel_speed_rad_s": wanted,
            "attitude_tolerance_deg": 0.1,
            "rate_tolerance_rad_s": 1e-4,
        },
        "objective": {"kind": "net-power", "wheel_power": "wheels"},
    }
    result = jaxatt.solve(scenarios.from_mapping(document), starts=4)
    (phase,) = result.phases
    assert phase.reached
    np.testing.assert_allclose(phase.series["omega_bw"][-1], wanted, atol=1e-3)
    limit = np.asarray(result.scenario.vehicle.magnetorquers.dipole_limit)
    dipole = np.abs(phase.series["dipole"])
    assert (dipole <= limit * (1.0 + 1e-9)).all()
    assert dipole.max() > 0.05 * limit.max()
