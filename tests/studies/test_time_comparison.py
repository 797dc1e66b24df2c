"""The comparison of turns in minimum time, and the turn about its own axis."""

import json
import math

import handmade_results
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.spacecraft import create, reaction_wheels, thrusters
from jaxatt.studies import time_comparison
from jaxatt.studies.eigenaxis_time import (
    acceleration,
    eigenaxis_time,
    has_no_gyroscopic_torque,
)
from jaxatt.studies.time_comparison import compare_times, turn_angle

STEPS = {(1.25, "euler"): 0.6918, (1.25, "rk4"): 0.6913, (2.5, "euler"): 0.9012, (2.5, "rk4"): 0.9}


@pytest.fixture
def solved(monkeypatch):
    """`solve` replaced by results made by hand, and the cases that it was asked for."""
    asked = []

    def solve(case, starts=None, seed=None, report=None):
        asked.append(case)
        key = (round(turn_angle(case), 2), case.transcription.integration)
        return handmade_results.timed(case, STEPS.get(key, 0.0541))

    monkeypatch.setattr(time_comparison, "solve", solve)
    return asked


@pytest.mark.parametrize("name", ["mrp-k4", "mrp-k4-2.5rad"])
def test_both_targets_are_solved_with_both_integrations(solved, name):
    found = compare_times(scenarios.load(name))
    assert {(round(row.angle_rad, 2), row.integration) for row in found.rows} == set(STEPS)
    assert [case.transcription.attitude for case in solved] == ["mrp"] * 4
    text = " ".join(str(found).split())
    assert "The text says 2.5 rad, but the sigma that it prints is that of 1.25 rad." in text
    assert "1.25 rad with forward Euler comes nearest to the printed 24.2124 s: +0.0006 s" in text
    assert "24.2130 (24.2124)" in text and "0.6918 (0.6918)" in text
    assert "about its own axis takes at least" in text


def test_forward_euler_is_not_refused_for_its_own_error(solved):
    compare_times(scenarios.load("mrp-k4-rk4"))
    allowed = {
        case.transcription.integration: math.degrees(case.targets[0].attitude_tolerance)
        for case in solved
    }
    assert allowed == {"euler": pytest.approx(2.0), "rk4": pytest.approx(0.01)}


def test_one_target_without_another_printed(solved):
    found = compare_times(scenarios.load("minimum-time-180"))
    assert len(found.rows) == 2
    assert "at least 3.54491 s" in " ".join(str(found).split())


def test_files_of_a_comparison(solved, tmp_path, monkeypatch):
    # The files of single results have their own tests, and figures take seconds.
    monkeypatch.setattr(time_comparison, "save_result", lambda result, folder: [folder / "files"])
    files = compare_times(scenarios.load("mrp-k4")).save(tmp_path)
    names = {str(path.relative_to(tmp_path)) for path in files}
    assert {"comparison.json", "comparison.png", "2.5-rad-Runge-Kutta/files"} <= names
    written = json.loads((tmp_path / "comparison.json").read_text())
    assert len(written["rows"]) == 4 and written["printed"]["time-effort"]["step_s"] == 0.6918


def test_the_unit_body_turns_half_round_in_twice_the_root_of_pi():
    craft = scenarios.load("minimum-time-180").vehicle
    assert eigenaxis_time(craft, np.array([0.0, 0.0, 1.0]), math.pi) == pytest.approx(
        2.0 * math.sqrt(math.pi), rel=1e-12
    )
    # About the diagonal of the cube of torques sqrt(3) acts.
    diagonal = np.ones(3) / math.sqrt(3.0)
    assert eigenaxis_time(craft, diagonal, math.pi) == pytest.approx(
        2.0 * math.sqrt(math.pi / math.sqrt(3.0)), rel=1e-12
    )


def test_the_largest_torque_along_a_direction_is_that_of_a_linear_programme():
    linprog = pytest.importorskip("scipy.optimize").linprog
    random = np.random.default_rng(11)
    for wheels, jets in ((3, 0), (5, 0), (4, 3), (3, 8)):
        axes, pushes = random.normal(size=(3, wheels)), random.normal(size=(3, jets))
        limit, strong = random.uniform(0.2, 1.0, wheels), random.uniform(0.2, 1.0, jets)
        mounted = reaction_wheels(axes, 1e-3, limit)
        craft = create(np.eye(3), mounted, "box", thrusters(pushes, strong) if jets else None)
        columns = np.concatenate([craft.wheels.axes, craft.thrusters.distribution], axis=1)
        direction = random.normal(size=3)
        answer = linprog(
            np.r_[np.zeros(wheels + jets), -1.0],
            A_eq=np.c_[columns, -direction],
            b_eq=np.zeros(3),
            bounds=[(-m, m) for m in limit] + [(0.0, m) for m in strong] + [(0.0, None)],
        )
        assert acceleration(craft, direction) == pytest.approx(-answer.fun, rel=1e-9)


def test_gyroscopic_torque_is_known():
    jets = scenarios.load("eseo-1").vehicle
    assert has_no_gyroscopic_torque(jets, np.array([0.0, 1.0, 0.0]))
    assert not has_no_gyroscopic_torque(jets, np.array([0.6, 0.8, 0.0]))
    assert has_no_gyroscopic_torque(scenarios.load("mrp-k3").vehicle, np.array([0.6, 0.8, 0.0]))
