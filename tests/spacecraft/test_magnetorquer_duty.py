"""Magnetorquers that act for a share of every period: means over it, and time at the limit."""

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.spacecraft import FieldError, magnetorquers
from jaxatt.spacecraft.actuation_power import magnetorquer_power

RNG = np.random.default_rng(23)
COILS = {"turns": 1e5, "coil_area": 8e-5, "resistance": 500.0}


@pytest.mark.parametrize("power", [{"full_power": 2.5}, COILS])
def test_mean_dipole_and_power_are_those_of_the_acting_share(power):
    limit, share = RNG.uniform(0.1, 0.5, 3), float(RNG.uniform(0.2, 0.9))
    always, sharing = magnetorquers(limit, **power), magnetorquers(limit, duty=share, **power)
    np.testing.assert_allclose(sharing.dipole_limit, share * limit)
    mean = RNG.uniform(-1.0, 1.0, (50, 3)) * sharing.dipole_limit
    np.testing.assert_allclose(
        magnetorquer_power(sharing, mean),
        share * magnetorquer_power(always, mean / share),
        rtol=1e-12,
    )


@pytest.mark.parametrize("duty", [0.0, -0.5, 1.5, [0.5, 0.5, 0.5], "half"])
def test_a_duty_is_a_share(duty):
    with pytest.raises(FieldError, match="duty"):
        magnetorquers(0.3, duty=duty)


def test_every_scenario_reads_it_and_says_what_is_left():
    case = scenarios.replace(scenarios.load("mtq-free-time"), {"vehicle.magnetorquers.duty": 0.5})
    np.testing.assert_allclose(case.vehicle.magnetorquers.dipole_limit, 0.17)
    assert any("act for 0.5 of every period" in note for note in case.notes)
    with pytest.raises(scenarios.ScenarioError, match=r"\[vehicle.magnetorquers\] duty = 2.0"):
        scenarios.replace(case, {"vehicle.magnetorquers.duty": 2.0})


def test_unloading_keeps_the_mean_limit_and_tells_the_time_at_it():
    """Every sample is recorded, so that the share can be counted again."""
    flight = scenarios.load_flight("hypso1-pointing-unloading")
    limit = float(flight.vehicle.magnetorquers.dipole_limit[0])
    speeds = [300.0, -250.0, 200.0, 100.0]
    short = {"simulation.duration_s": 4.0, "simulation.records": 200, "dumping.gain_1_s": 2e-3}
    shares = []
    for duty in (1.0, 0.4):
        changed = {"vehicle.magnetorquers.duty": duty, "initial.wheel_speed_rad_s": speeds}
        result = jaxatt.simulate(scenarios.replace_in_flight(flight, {**short, **changed}))
        dipole = np.abs(np.asarray(result.flown.recorded.dipole)[0])
        assert dipole.shape == (200, 3)
        assert dipole.max() <= duty * limit * (1.0 + 1e-12)
        counted = float((dipole >= duty * limit * (1.0 - 1e-12)).any(axis=1).mean())
        told = result.summary()["dipole_saturated_percent"]["p50"]
        assert told == pytest.approx(100.0 * counted)
        shares.append(counted)
    assert shares[1] > 0.0 and shares[1] >= shares[0]
