"""summary.json: stable names, sums over phases, nothing that JSON cannot hold."""

import json
import math

import pytest

from jaxatt.report.summary import summary, write_summary

NAMES = {
    "scenario",
    "status",
    "objective",
    "active_intervals",
    "active_interval_indices",
    "weighted_active_intervals",
    "active_outside_windows",
    "relative_sparsity_percent",
    "attitude_error_deg",
    "rate_error_rad_s",
    "max_torque_violation_Nm",
    "max_complementarity_Nm",
    "starts",
    "time_s",
    "legs",
    "seed",
    "device",
    "precision",
    "versions",
}


def test_names_and_values_of_one_leg(make, tmp_path):
    write_summary(make(), tmp_path / "summary.json")
    found = json.loads((tmp_path / "summary.json").read_text())
    assert set(found) >= NAMES
    assert found["scenario"] == "hypso1-90-45-15"
    assert found["status"] == "reached"
    assert found["objective"] == {"total": 23.0, "rate": 1.0, "attitude": 2.0, "sparsity": 20.0}
    assert found["active_interval_indices"] == [0, 20, 49]
    assert found["active_outside_windows"] == 2
    assert found["weighted_active_intervals"] == pytest.approx(2.001)
    assert found["relative_sparsity_percent"] == pytest.approx(6.0)
    assert found["attitude_error_deg"] == pytest.approx(0.005)
    assert found["starts"] == {
        "requested": 6,
        "converged": 2,
        "reached_target": 3,
        "distinct_minima": 2,
    }
    assert found["time_s"] == {"compile": 1.5, "solve": 2.5, "verify": 0.25}
    assert found["legs"] == []
    assert found["waypoint_error_deg"] is None and found["state_error"] is None
    assert found["notes"] == ["a note"]
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


def test_several_legs_are_added_up_and_listed(make):
    found = summary(make("hypso1-path-two"))
    assert found["active_intervals"] == 6
    assert found["active_interval_indices"] == [0, 20, 49, 50, 70, 99]
    assert found["relative_sparsity_percent"] == pytest.approx(6.0)
    assert found["objective"]["total"] == pytest.approx(46.0)
    assert found["attitude_error_deg"] == pytest.approx(0.005)
    assert found["starts"]["requested"] == 12
    assert [phase["leg"] for phase in found["legs"]] == [1, 2]
    assert found["legs"][1]["active_interval_indices"] == [0, 20, 49]
    assert not {"time_s", "versions"} & set(found["legs"][0])


def test_a_leg_that_fails_makes_the_whole_fail_and_numbers_that_are_not_finite_are_null(make):
    failed = {"reached": False, "errors": {"attitude": math.nan, "rate": math.inf}}
    found = summary(make("hypso1-path-two", **failed))
    assert found["status"] == "not reached"
    assert found["attitude_error_deg"] is None
    assert found["rate_error_rad_s"] is None
    json.dumps(found, allow_nan=False)


def test_doing_nothing_and_the_answer_that_reaches(resting):
    found = summary(resting)
    assert found["status"] == "not reached"
    assert found["do_nothing_cost"] == pytest.approx(7.612)
    assert found["alternative"]["status"] == "reached"
    assert found["alternative"]["objective"]["total"] == pytest.approx(20.0)


def test_toy(make):
    found = summary(make("double-integrator"))
    assert found["state_error"] == pytest.approx(1e-8)
    assert found["attitude_error_deg"] is None and found["rate_error_rad_s"] is None
    assert found["l1_effort_Nms"] == pytest.approx(0.5)
