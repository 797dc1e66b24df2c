"""A final time that is to be found: what a scenario may say of it, and what is refused."""

import copy
import tomllib

import pytest

from jaxatt import scenarios
from jaxatt.pipeline.simulate import plan_of
from jaxatt.scenarios import ScenarioError

DOCUMENT = tomllib.loads(scenarios.text("hypso1-90-0-0"))
FREE = {"intervals": 50, "final_time": "free", "longest_s": 90.0}


def read(horizon=None, objective=None, **tables):
    document = {**copy.deepcopy(DOCUMENT), **tables}
    document["horizon"] = horizon or FREE
    document["objective"].update(objective or {})
    return scenarios.from_mapping(document)


def test_a_free_final_time_needs_the_longest_only():
    horizon = read().horizon
    assert horizon.free
    assert (horizon.shortest, horizon.duration, horizon.longest) == (0.0, 90.0, 90.0)


def test_a_first_guess_and_a_shortest_time_may_be_given():
    case = read({**FREE, "horizon_s": 70.0, "shortest_s": 30}, {"time_weight_1_s": 0.05})
    assert (case.horizon.shortest, case.horizon.duration) == (30.0, 70.0)
    assert case.objective.time_weight == 0.05


def test_the_final_time_is_fixed_unless_said_otherwise():
    horizon = scenarios.load("hypso1-90-0-0").horizon
    assert not horizon.free
    assert horizon.duration == 70.0


def test_a_waypoint_by_node_moves_with_the_final_time():
    passing = {"attitude_deg": [45, 0, 0], "node": 25}
    case = read(waypoint=passing)
    assert case.waypoint.node == 25
    assert case.waypoint.time == pytest.approx(45.0)
    fixed = read({"horizon_s": 70.0, "intervals": 50}, waypoint=passing)
    assert fixed.waypoint.time == pytest.approx(35.0)


@pytest.mark.parametrize(
    ("horizon", "objective", "words"),
    [
        ({**FREE, "shortest_s": 91.0}, {}, r"shortest_s = 91\.0: more than longest_s = 90"),
        ({**FREE, "horizon_s": 100.0}, {}, r"horizon_s = 100\.0: outside the final times.*0 to 90"),
        ({**FREE, "horizon_s": 20.0, "shortest_s": 30.0}, {}, "30 to 90 seconds"),
        ({**FREE, "longest_s": -1.0}, {}, "longest_s.*greater than 0"),
        ({**FREE, "longest_s": float("nan")}, {}, "longest_s.*finite"),
        ({**FREE, "shortest_s": -1.0}, {}, "shortest_s.*at least 0"),
        ({**FREE, "final_time": "maybe"}, {}, "final_time.*allowed: fixed, free"),
        ({"intervals": 50, "final_time": "free"}, {}, "horizon_s: missing"),
        (
            {"intervals": 50, "final_time": "free", "horizon_s": 70.0},
            {},
            "longest_s: missing.*kind = l0 needs the longest",
        ),
        ({"intervals": 50, "horizon_s": 70.0, "longest_s": 90.0}, {}, "longest_s.*is fixed"),
        (FREE, {"time_weight_1_s": -0.1}, "time_weight_1_s.*at least 0"),
        (FREE, {"time_weight": 0.1}, "did you mean 'time_weight_1_s'"),
        (
            {"intervals": 50, "horizon_s": 70.0},
            {"time_weight_1_s": 0.1},
            "time_weight_1_s = 0.1: the final time is fixed",
        ),
    ],
)
def test_bad_input(horizon, objective, words):
    with pytest.raises(ScenarioError, match=words):
        read(horizon, objective)


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"windows": [{"start_s": 28, "end_s": 42}]}, "start_s.*give first_interval"),
        ({"waypoint": {"attitude_deg": [9, 0, 0], "time_s": 20.0}}, "time_s.*give node"),
        ({"waypoint": {"attitude_deg": [9, 0, 0], "node": 50}}, "node = 50: outside.*1 to 49"),
        ({"waypoint": {"attitude_deg": [9, 0, 0], "node": 0}}, "node.*at least 1"),
        (
            {"waypoint": {"attitude_deg": [9, 0, 0], "node": 3, "time_s": 20.0}},
            "time_s.*given beside node",
        ),
    ],
)
def test_times_in_seconds_are_refused_where_intervals_have_no_length_yet(tables, words):
    with pytest.raises(ScenarioError, match=words):
        read(**tables)


def test_the_toys_have_a_free_final_time_too():
    document = tomllib.loads(scenarios.text("double-integrator"))
    document["horizon"] = {"intervals": 40, "final_time": "free", "longest_s": 8.0}
    document["objective"]["time_weight_1_s"] = 0.5
    case = scenarios.from_mapping(document)
    assert case.horizon.duration == 8.0
    assert case.objective.time_weight == 0.5


def test_a_flight_cannot_follow_intervals_of_any_length():
    flight = scenarios.replace_in_flight(
        scenarios.load_flight("hypso1-tracking"), {"reference.manoeuvre": "hypso1-90-0-0-free"}
    )
    with pytest.raises(ScenarioError, match=r"hypso1-90-0-0-free.*final time is free.*fixed final"):
        plan_of(flight)
