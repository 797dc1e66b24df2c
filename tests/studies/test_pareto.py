"""Pareto fronts of energy over time and over the error at the end, of a small programme."""

import csv
import dataclasses
import json

import numpy as np
import pytest

import jaxatt
from jaxatt import ScenarioError, scenarios
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.front import dominated
from jaxatt.problems.net_power.answers import flown_again
from jaxatt.problems.net_power.build import manoeuvre_of
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.studies.pareto import front_request

STARTS = 3
SUN = 16.332
"""[W], of the best attitude: 1361 W/m^2 on the panels of the vehicle."""


@pytest.fixture(scope="module")
def scenario():
    horizon = {"horizon_s": 20.0, "intervals": 32}
    changes = {"horizon": horizon, "solver.starts": STARTS, "baseline": None}
    return scenarios.replace(scenarios.load("hypso1-netpower"), changes)


@pytest.fixture(scope="module")
def over_time(scenario):
    return jaxatt.pareto(scenario, "time", values=[24.0, 8.0, 16.0, 20.0])


@pytest.fixture(scope="module")
def over_error(scenario):
    return jaxatt.pareto(scenario, "error", values=[10.0, 300.0, 3e3, 3e4])


def test_energy_rises_with_time_to_the_power_of_the_sun(over_time):
    front = over_time.front
    assert front.costs.tolist() == [8.0, 16.0, 20.0, 24.0]
    assert front.best.tolist() == [False, True, True, True]
    assert (np.diff(front.gains[front.best]) > 0.0).all()
    # A long manoeuvre spends what is added to it in the sun attitude.
    assert over_time.price[-1] == pytest.approx(SUN, rel=2e-2)
    assert (front.gains < SUN * front.costs).all()
    assert [len(phase.controls) for phase in front.phases] == 4 * [39]


def test_too_short_a_time_is_told_and_not_on_the_front(over_time):
    assert not over_time.reached
    row = over_time.rows()[0]
    assert not row["reached"]
    assert "target attitude is missed" in row["reason"]
    assert "final time 8 s: the target attitude is missed" in " ".join(str(over_time).split())


def test_a_point_earns_what_a_search_of_its_own_earns(over_time):
    front = over_time.front
    found = net_power(front.phases[2])
    horizon = scenarios.Horizon(20.0, 39, 0, None)
    scenario = dataclasses.replace(over_time.scenario, horizon=horizon)
    alone = manoeuvre_of(scenario, PhaseStart())
    # As many as there are points, so that it shares their compiled program.
    answers = search_wheels([alone] * len(front.costs), STARTS, 0)[0]
    flown = flown_again(alone, answers)
    assert flown.reached.any()
    assert front.gains[2] >= flown.flight.energy.net_J[flown.best] - 1e-6
    assert found.energy.net == front.gains[2]
    assert found.start_energy.shape == (STARTS,)


def test_every_error_is_the_best_for_its_weight(over_error):
    front = over_error.front
    assert front.best.all()
    assert (np.diff(front.costs) < 0.0).all()
    assert front.costs[-1] < 0.3
    for phase in front.phases:
        assert phase.errors["rate"] <= 1e-5
    missed = 1.0 - np.cos(0.5 * np.radians(front.costs))
    merit = front.gains[None] - front.values[:, None] * missed[None]
    assert (np.diag(merit) >= merit.max(axis=1) - 0.1).all()


def test_energy_for_accuracy_is_what_the_weights_say(over_error):
    front = over_error.front
    missed = 1.0 - np.cos(0.5 * np.radians(front.costs))
    # The derivative of energy by the cost's error is the weight, so between two it is in between.
    between = np.diff(front.gains) / np.diff(missed)
    assert (between > front.values[:-1]).all()
    assert (between < front.values[1:]).all()


def test_files_can_be_opened_again(over_error, tmp_path):
    files = over_error.save(tmp_path)
    assert [file.name for file in files] == ["pareto.csv", "pareto.json", "pareto.png"]
    with (tmp_path / "pareto.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    kept = json.loads((tmp_path / "pareto.json").read_text())
    front = over_error.front
    assert [float(row["attitude_error_deg"]) for row in rows] == front.costs.tolist()
    assert [point["net_J"] for point in kept["points"]] == front.gains.tolist()
    assert (kept["over"], kept["varied"]) == ("error", "attitude_weight_J")
    controls = np.array([point["controls"] for point in kept["points"]])
    assert controls.shape == (4, 32, 3)
    assert np.array_equal(controls[1], front.phases[1].controls)
    assert (tmp_path / "pareto.png").stat().st_size > 10_000


def test_the_table_shows_every_point(over_error):
    text = str(over_error)
    assert "4 of 4 points on the front" in text
    assert all(f"{error:.4g}" in text for error in over_error.front.costs)


def test_dominated_points_are_those_that_another_beats():
    rng = np.random.default_rng(20261129)
    costs, gains = rng.integers(0, 6, (2, 40)).astype(float)
    among = rng.random(40) < 0.7
    found = dominated(costs, gains, among)
    for k in range(40):
        beaten = any(
            among[n]
            and costs[n] <= costs[k]
            and gains[n] >= gains[k]
            and (costs[n], gains[n]) != (costs[k], gains[k])
            for n in range(40)
        )
        assert found[k] == beaten
    assert 0 < found.sum() < 40


@pytest.mark.parametrize(
    ("over", "points", "values", "words"),
    [
        ("money", None, None, 'over = \'money\': choose "time" or "error"'),
        ("time", 1, None, "points = 1: a front needs at least two"),
        ("time", 3, [1.0, 2.0], "give one of the two"),
        ("time", None, [5.0, -1.0], "must be positive"),
        ("error", None, [0.0, 1.0], "must be positive"),
        ("error", None, [1.0, float("nan")], "must be positive"),
        ("time", None, [5.0, 5.0], "at least two different ones"),
        ("time", None, [], "at least two different ones"),
    ],
)
def test_what_makes_no_front_is_refused(over, points, values, words):
    with pytest.raises(ScenarioError, match=words):
        front_request(over, points, values)


@pytest.mark.parametrize(
    ("name", "changes", "over", "words"),
    [
        ("double-integrator", {}, "time", "gains no energy"),
        ("mrp-k4", {}, "error", "gains no energy"),
        ("hypso2-orbit", {}, "time", "is a plan"),
        ("hypso1-netpower", {"target": {}}, "error", r"\[target\] has no attitude"),
        (
            "hypso1-netpower",
            {"target.wheel_speed_rad_s": [1.0, 0.0, 0.0]},
            "error",
            "wheel_speed_rad_s: not together",
        ),
    ],
)
def test_scenarios_without_a_front_are_refused(name, changes, over, words):
    with pytest.raises(ScenarioError, match=words):
        jaxatt.pareto(scenarios.replace(scenarios.load(name), changes), over)


def test_no_starts_are_refused():
    with pytest.raises(ScenarioError, match="at least one start"):
        jaxatt.pareto("hypso1-netpower", starts=0)
