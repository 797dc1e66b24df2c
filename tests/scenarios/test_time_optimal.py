"""Turns whose time is minimised: the bundled cases, what may be said of them, what is refused."""

import copy
import math
import tomllib

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

DOCUMENT = tomllib.loads(scenarios.text("mrp-k4"))
WHEELS = {"axes": np.eye(3).tolist(), "inertia_kgm2": 0.05, "torque_limit_Nm": 0.5}
BODY = {"inertia_kgm2": np.diag([2.0, 2.0, 3.0]).tolist(), "wheels": WHEELS}
SIGMA = (0.1582, 0.0657, 0.2740)
AXIS = np.array([0.4896, 0.2032, 0.8480])


def edited(changes, base=DOCUMENT):
    """A document with tables or "table.key" replaced; None drops one."""
    document = copy.deepcopy(base)
    for path, value in changes.items():
        *parents, key = path.split(".")
        place = document
        for part in parents:
            place = place.setdefault(part, {})
        place.pop(key, None)
        if value is not None:
            place[key] = value
    return document


def read(**changes):
    return scenarios.from_mapping(edited({k.replace("__", "."): v for k, v in changes.items()}))


def turn(case):
    """Angle [rad] and axis of the target against the start."""
    q = case.targets[0].q_ob
    return 2.0 * math.atan2(np.linalg.norm(q[1:]), q[0]), q[1:] / np.linalg.norm(q[1:])


@pytest.mark.parametrize("wheels", [3, 4, 5])
@pytest.mark.parametrize("form", ["", "-rk4", "-2.5rad"])
def test_the_bundled_turns_hold_the_printed_values(wheels, form):
    case = scenarios.load(f"mrp-k{wheels}{form}")
    vehicle = case.vehicle
    np.testing.assert_array_equal(np.diag(vehicle.inertia), [86.215, 85.070, 133.565])
    assert vehicle.wheels.count == wheels
    assert np.all(np.asarray(vehicle.wheels.torque_limit) == 0.55)
    assert np.all(np.asarray(vehicle.wheels.inertia) == 0.05)
    columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    columns += [[sign * 0.5, math.sqrt(0.5), sign * 0.5] for sign in (1, -1)]
    np.testing.assert_allclose(vehicle.wheels.axes.T, columns[:wheels], atol=1e-15)
    assert (case.objective.kind, case.objective.effort_weight) == ("time-effort", 0.01)
    assert case.transcription.attitude == ("quaternion" if form == "-rk4" else "mrp")
    assert case.transcription.integration == ("rk4" if form == "-rk4" else "euler")
    assert case.horizon.free and case.horizon.intervals == 35 and case.horizon.longest == math.inf
    assert (case.solver.starts, case.control.axes) == (21, "wheels")
    angle, axis = turn(case)
    if form == "-2.5rad":
        assert angle == pytest.approx(2.5, abs=1e-12)
        assert "length was 1.00005" in " ".join(case.notes)
    else:
        assert angle == pytest.approx(4.0 * math.atan(np.linalg.norm(SIGMA)), abs=1e-12)
        assert angle == pytest.approx(1.25, abs=3e-4)  # of four digits
        assert case.notes == ()
    np.testing.assert_allclose(axis, AXIS / np.linalg.norm(AXIS), atol=3e-4)


def test_the_half_turn_has_a_torque_of_one_about_every_axis_in_both_senses():
    case = scenarios.load("minimum-time-180")
    thrust = np.asarray(case.vehicle.thrusters.distribution) * case.vehicle.thrusters.torque_limit
    np.testing.assert_array_equal(np.maximum(thrust, 0.0).sum(axis=1), [1.0, 1.0, 1.0])
    np.testing.assert_array_equal(np.minimum(thrust, 0.0).sum(axis=1), [-1.0, -1.0, -1.0])
    assert case.objective.kind == "minimum-time"
    assert case.transcription == scenarios.Transcription("quaternion", "rk4")
    angle, axis = turn(case)
    assert angle == pytest.approx(math.pi, abs=1e-12)
    np.testing.assert_allclose(axis, [0, 0, 1], atol=1e-12)


def test_all_forms_of_an_attitude_agree():
    random = np.random.default_rng(7)
    for _ in range(20):
        axis = random.normal(size=3)
        angle = random.uniform(-2 * math.pi, 2 * math.pi)
        unit = axis / np.linalg.norm(axis)
        q = np.r_[math.cos(angle / 2), math.sin(angle / 2) * unit]
        forms = [
            {"attitude_quaternion": q.tolist()},
            {"attitude_mrp": (unit * math.tan(angle / 4)).tolist()},
            {"axis": axis.tolist(), "angle_rad": angle},
            {"axis": axis.tolist(), "angle_deg": math.degrees(angle)},
        ]
        for form in forms:
            np.testing.assert_allclose(read(target=form).targets[0].q_ob, q, atol=1e-12)


def test_replace_exchanges_one_form_of_an_attitude_for_another():
    case = scenarios.load("mrp-k4")
    turned = scenarios.replace(case, {"target.axis": [0, 1, 0], "target.angle_deg": 90})
    assert turn(turned)[0] == pytest.approx(math.pi / 2)
    wider = scenarios.replace(turned, {"target.angle_rad": 2.0})
    assert turn(wider)[0] == pytest.approx(2.0)
    back = scenarios.replace(wider, {"target.attitude_mrp": SIGMA})
    np.testing.assert_array_equal(back.targets[0].q_ob, case.targets[0].q_ob)


def test_minimum_time_says_that_it_does_not_use_the_weight():
    case = read(objective__kind="minimum-time")
    assert case.objective.effort_weight == 0.0
    assert any("effort_weight is not used" in note for note in case.notes)


def test_limits_of_the_final_time_may_be_given():
    case = read(horizon={"intervals": 20, "final_time": "free", "shortest_s": 5, "longest_s": 90})
    assert (case.horizon.shortest, case.horizon.longest) == (5.0, 90.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        # a whole turn
        ({"target": {"attitude_mrp": [0, 0, math.inf]}}, "attitude_mrp.*must be finite"),
        ({"target": {"attitude_mrp": [-1e9, 0, 0]}}, r"attitude_mrp.*360.*0\.0\] is the same"),
        ({"target": {"attitude_mrp": [math.nan, 0, 0]}}, "attitude_mrp.*must be finite"),
        ({"target": {"attitude_mrp": [0, 0]}}, "attitude_mrp.*2 entries"),
        ({"target": {"axis": [0, 0, 1], "angle_deg": 360}}, "angle_deg = 360.*0 is the same"),
        ({"target": {"axis": [0, 0, 1], "angle_rad": -2 * math.pi}}, "angle_rad.*360 deg"),
        ({"target": {"axis": [0, 0, 1], "angle_deg": 400}}, "more than a whole turn.*360 deg"),
        # forms of an attitude
        ({"target": {"axis": [0, 0, 0], "angle_deg": 90}}, "axis.*is zero"),
        ({"target": {"axis": [0, 0, 1]}}, "angle_deg: missing"),
        ({"target": {"angle_deg": 90}}, "axis: missing"),
        ({"target": {"axis": [0, 0, 1], "angle_deg": 9, "angle_rad": 1}}, "beside angle_deg"),
        ({"target": {"attitude_mrp": [0, 0, 1], "attitude_deg": [0, 0, 9]}}, "keep one"),
        ({"target": {"attitude_mrp": [0, 0, 1], "axis": [0, 0, 1]}}, "axis.*beside attitude_mrp"),
        # the time is found, the torques are separate
        ({"horizon.horizon_s": 70.0}, "horizon_s = 70.0.*finds the final time.*shortest_s"),
        ({"horizon.coast_intervals": 5}, "coast_intervals"),
        ({"horizon.final_time": "fixed"}, "final_time.*finds the final time"),
        ({"horizon.intervals": None}, "intervals: missing"),
        ({"control": {"axes": "body"}}, 'axes.*use "wheels"'),
        # objectives
        ({"objective.effort_weight": -0.01}, "effort_weight = -0.01: must be at least 0"),
        ({"objective.effort_weight": math.nan}, "effort_weight.*finite"),
        ({"objective.terminal": "penalty"}, "terminal.*always reaches"),
        ({"objective.design": 2}, "design.*sparse"),
        ({"objective.kind": "time"}, "kind.*time-effort"),
        ({"transcription.attitude": "euler"}, "attitude.*quaternion, mrp"),
        ({"transcription.integration": "rk5"}, "did you mean 'rk4'"),
        ({"legs": [{"attitude_deg": [1, 2, 3]}], "target": None}, "legs: not with.*one target"),
        ({"waypoint": {"attitude_deg": [1, 2, 3], "node": 5}}, "waypoint: not with"),
        ({"windows": [{"first_interval": 1, "last_interval": 2}]}, "windows: not with"),
        ({"disturbances": {"gravity_gradient": True}}, "disturbances: not with"),
        # the same words where they mean nothing
        (
            {"objective": {"kind": "l0", "effort_weight": 0.1}, "horizon.horizon_s": 70.0},
            'effort_weight.*not used by kind = l0; use kind = "time-effort"',
        ),
        # vehicles
        (
            {"vehicle": {**BODY, "wheels": {**WHEELS, "axes": [[1, 0, 0], [0, 1, 0]]}}},
            "axes.*span 2 of the three.*no wheel can turn the body about",
        ),
        (
            {"vehicle": {**BODY, "wheels": {**WHEELS, "axes": [[1, 0, 0], [0, 1, 0], [1, 1, 0]]}}},
            "3 wheel axes span 2 of the three",
        ),
    ],
)
def test_bad_input(changes, words):
    with pytest.raises(ScenarioError, match=words):
        scenarios.from_mapping(edited(changes))


def test_a_sparse_objective_takes_no_transcription():
    document = edited(
        {"transcription": {"attitude": "mrp"}}, tomllib.loads(scenarios.text("hypso1-90-0-0"))
    )
    with pytest.raises(ScenarioError, match=r"transcription.*not used by kind = l0"):
        scenarios.from_mapping(document)


def test_wheels_that_are_no_unit_vectors_are_scaled_with_a_note():
    axes = [[2.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    case = read(vehicle={**BODY, "wheels": {**WHEELS, "axes": axes}})
    np.testing.assert_allclose(np.linalg.norm(case.vehicle.wheels.axes, axis=0), 1.0)
    assert len(case.notes) == 2


def spinning(angle_deg, limit, speed=100.0):
    """A turn about z with the first of three wheels along the axes spinning at the start."""
    return read(
        vehicle={**BODY, "wheels": {**WHEELS, "speed_limit_rad_s": limit}},
        initial={"attitude_mrp": [0, 0, 0], "wheel_speed_rad_s": [speed, 0, 0]},
        target={"axis": [0, 0, 1], "angle_deg": angle_deg},
    )


def test_speed_limits_that_hold_the_momentum_at_the_target_pass():
    # After 45 deg two wheels share the momentum, each 100 cos(45 deg) rad/s; after 90 deg the
    # second has all of it.
    spinning(45, [101.0, 70.8, 1.0])
    spinning(90, [101.0, 100.1, 1.0])
    spinning(180, [101.0, 1.0, 1.0])


@pytest.mark.parametrize(("angle", "share"), [(45, r"1\.01"), (90, r"1\.429")])
def test_speed_limits_that_cannot_hold_the_momentum_at_the_target_are_named(angle, share):
    with pytest.raises(ScenarioError, match=rf"speed_limit_rad_s: at the target.*{share}.* times"):
        spinning(angle, [101.0, 70.0, 1.0])
