"""A free final time against analytic answers, and what it must never do worse than a fixed one.

Bang-off-bang control of a double integrator, rest to rest over a distance d, for fuel and time:
Athans and Falb (1966), "Optimal Control", chapter 8.  On N intervals of a step h, bursts of m whole
intervals and a share f of the next at each end cover h^2 (m (N - m) + f (N - 1 - 2 m)).
"""

import numpy as np
import pytest
from references import reflight

import jaxatt
from jaxatt import scenarios
from jaxatt.multistart import driver

N, LONGEST = 40, 9.0


def free(distance, weight, kind="l0", **changes):
    return scenarios.replace(
        scenarios.load("double-integrator"),
        {
            "initial.state": [0.0, 0.0],
            "target.state": [distance, 0.0],
            "horizon": {"intervals": N, "final_time": "free", "longest_s": LONGEST},
            "objective.kind": kind,
            "objective.time_weight_1_s": weight,
            "solver.starts": 8,
            **changes,
        },
    )


def least_times(distance):
    """Least final times of bursts of 1 .. N/2 intervals at each end."""
    m = np.arange(1, N // 2 + 1)
    return m, N * np.sqrt(distance / (m * (N - m)))


def active_shares(distance, times):
    """Intervals 2 (m + f) at the limit that cover a distance in each of some times."""
    m = np.arange(N // 2 + 1)
    covered = m * (N - m)
    return 2.0 * np.interp(distance * (N / times) ** 2, covered, m)


@pytest.mark.parametrize("seed", range(4))
def test_the_least_count_with_its_time_is_that_of_two_bursts(seed):
    rng = np.random.default_rng(seed)
    distance, weight = rng.uniform(0.5, 4.0), 10.0 ** rng.uniform(-1.0, 1.2)
    m, times = least_times(distance)
    costs = np.where(times <= LONGEST, 2 * m + weight * times, np.inf)
    result = jaxatt.solve(free(distance, weight))
    phase = result.phases[0]
    assert phase.reached
    assert phase.section.final_times.cost == pytest.approx(
        phase.active_intervals + weight * phase.final_time
    )
    assert phase.section.final_times.cost == pytest.approx(costs.min(), rel=1e-7)
    assert phase.final_time == pytest.approx(times[np.argmin(costs)], rel=1e-7)
    np.testing.assert_allclose(np.abs(phase.controls[phase.active]), 1.0, rtol=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_fuel_and_time_are_traded_as_athans_and_falb_have_it(seed):
    rng = np.random.default_rng(seed)
    distance, weight = rng.uniform(0.5, 1.5), rng.uniform(0.8, 3.0)
    result = jaxatt.solve(free(distance, weight, "l1"))
    phase = result.phases[0]
    assert phase.reached

    times = np.linspace(2.001 * np.sqrt(distance), LONGEST, 200_001)
    costs = active_shares(distance, times) * times / LONGEST + weight * times
    assert phase.section.final_times.cost == pytest.approx(costs.min(), rel=1e-5)
    assert phase.final_time == pytest.approx(times[np.argmin(costs)], rel=0.02)

    # On a fine grid: fuel T - sqrt(T^2 - 4 d), so k T + fuel is least where dfuel/dT = -k.
    k = weight * LONGEST / N
    smooth = 2.0 * np.sqrt(distance) * (1.0 + k) / np.sqrt(k * (2.0 + k))
    assert phase.final_time == pytest.approx(smooth, rel=0.06)
    fuel = smooth - np.sqrt(smooth**2 - 4.0 * distance)
    assert phase.section.final_times.cost == pytest.approx(
        (fuel + k * smooth) * N / LONGEST, rel=0.01
    )


def test_another_distance_and_price_do_not_compile_anew():
    jaxatt.solve(free(1.0, 2.0))
    large = [run._jitted for run in (driver.some_passes, driver.to_the_end)]
    compiled = [run._cache_size() for run in large]
    jaxatt.solve(free(2.5, 7.0))
    assert [run._cache_size() for run in large] == compiled


def test_dear_time_leads_to_the_least_time():
    """Which is 2 sqrt(d); the fuel still adds a third of a percent at this price."""
    phase = jaxatt.solve(free(1.0, 50.0, "l1")).phases[0]
    assert 2.0 <= phase.final_time <= 2.015


@pytest.mark.parametrize("kind", ["l0", "l1"])
def test_time_that_costs_nothing_is_not_worse_than_the_longest_fixed_one(kind):
    result = jaxatt.solve(free(1.7, 0.0, kind)).phases[0]
    horizon = {"intervals": N, "horizon_s": LONGEST}
    changes = {"horizon": horizon, "objective.time_weight_1_s": None}
    fixed = jaxatt.solve(scenarios.replace(free(1.7, 0.0, kind), changes)).phases[0]
    assert result.active_intervals <= fixed.active_intervals
    assert result.l1_effort <= fixed.l1_effort * (1.0 + 1e-9)


def test_a_target_that_is_the_start_takes_no_time():
    phase = jaxatt.solve(free(0.0, 0.3)).phases[0]
    assert phase.reached
    assert phase.active_intervals == 0
    assert phase.final_time <= 2e-3 * LONGEST


def test_a_shortest_time_is_kept():
    horizon = {"intervals": N, "final_time": "free", "shortest_s": 6.0, "longest_s": LONGEST}
    phase = jaxatt.solve(free(1.0, 20.0, horizon=horizon)).phases[0]
    assert phase.reached
    assert phase.final_time == pytest.approx(6.0)
    assert phase.section.final_times.final_time.min() >= 6.0


def test_where_nothing_reaches_that_is_said():
    result = jaxatt.solve(free(40.0, 0.3))
    tried = result.phases[0].section.final_times
    assert not result.reached
    assert result.phases[0].failure_reason
    assert not tried.reached.any()
    assert np.isinf(tried.costs).all()
    assert result.summary()["final_times"]["cost"] is None


@pytest.fixture(scope="module")
def slew():
    """A quarter turn where the orbit frame hardly turns."""
    scenario = scenarios.load("hypso1-90-0-0-free")
    return scenarios.replace(
        scenario,
        {
            "orbit.semi_major_axis_km": 9e5,
            "orbit.eccentricity": 0.0,
            "objective.time_weight_1_s": 0.05,
            "solver.starts": 8,
        },
    )


def test_two_pulses_of_a_slew_last_until_the_wheels_saturate(slew):
    result = jaxatt.solve(slew)
    phase, vehicle = result.phases[0], slew.vehicle
    assert result.reached
    assert np.flatnonzero(phase.active).tolist() == [0, 49]
    # Acceleration a about x at the limit of the wheels; pulses of h at the ends turn by a h^2 49.
    torque = np.asarray(vehicle.inertia_without_spin)[:, 0]
    share = np.abs(np.asarray(vehicle.wheels.allocation) @ torque)
    acceleration = float((np.asarray(vehicle.wheels.torque_limit) / share).min())
    least = 50.0 * np.sqrt(np.pi / 2.0 / (49.0 * acceleration))
    assert phase.final_time == pytest.approx(least, rel=1e-5)
    summary = result.summary()
    assert summary["final_time_s"] == pytest.approx(50.0 * summary["step_s"])
    reflight.assert_reached(slew, result)
    assert len(phase.section.final_times.how) == len(summary["final_times"]["tried"])


def test_every_leg_has_a_time_of_its_own_and_the_orbit_goes_on():
    horizon = {"intervals": 50, "final_time": "free", "longest_s": 80.0}
    scenario = scenarios.replace(
        scenarios.load("hypso1-path-two"),
        {
            "horizon": horizon,
            "objective.time_weight_1_s": 0.04,
            "solver.starts": 8,
            "windows": None,
            "legs.1.attitude_deg": [0.0, 10.0, -20.0],
        },
    )
    result = jaxatt.solve(scenario)
    first, second = result.phases
    assert second.start_time == pytest.approx(first.final_time)
    assert abs(second.final_time - first.final_time) > 1.0
    assert result.summary()["final_time_s"] == pytest.approx(first.final_time + second.final_time)
    reflight.assert_reached(scenario, result)
    # What makes it the least time: a wheel at its limit.
    for phase in result.phases:
        share = np.abs(phase.series["torque_wheels"]) / np.asarray(
            scenario.vehicle.wheels.torque_limit
        )
        assert share.max() == pytest.approx(1.0, abs=1e-6)
