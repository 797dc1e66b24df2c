"""What the loader accepts, converts and notes."""

import copy
import tomllib

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

DOCUMENT = tomllib.loads(scenarios.text("hypso1-90-45-15"))


def read(**tables):
    return scenarios.from_mapping({**copy.deepcopy(DOCUMENT), **tables})


def test_the_least_that_a_scenario_needs():
    least = {key: DOCUMENT[key] for key in ("vehicle", "orbit")}
    least["initial"] = {"attitude_deg": [0, 0, 0]}
    least["target"] = {"attitude_deg": [0, 0, 90]}
    least["horizon"] = {"horizon_s": 70, "intervals": 50}
    case = scenarios.from_mapping(least)
    assert case.name == case.title == "scenario"
    np.testing.assert_array_equal(case.initial.omega_bw, np.zeros(4))
    np.testing.assert_array_equal(case.initial.omega_ob, np.zeros(3))
    assert case.horizon.substeps is None
    assert case.windows == ()
    np.testing.assert_array_equal(scenarios.window_weights(case), np.ones(50))


@pytest.mark.parametrize("scale", [1.00009, 2.0, 1e-9, 1e200])
def test_a_quaternion_is_normalised_with_a_note(scale):
    quaternion = [0.5 * scale] * 4
    case = read(target={"attitude_quaternion": quaternion})
    np.testing.assert_allclose(case.targets[0].q_ob, [0.5] * 4, rtol=1e-15)
    assert case.notes == (f"[target] attitude_quaternion was normalised; its norm was {scale:.6g}",)


def test_a_unit_quaternion_is_taken_as_it_is():
    case = read(target={"attitude_quaternion": [0.0, -0.6, 0.0, 0.8]})
    np.testing.assert_allclose(case.targets[0].q_ob, [0.0, -0.6, 0.0, 0.8], rtol=1e-15)
    assert case.notes == ()


@pytest.mark.parametrize(
    ("start", "end", "first", "last"),
    [(28, 42, 20, 30), (10, 20, 7, 14), (49, 59, 35, 42), (0, 70, 0, 49), (69.9, 70, 49, 49)],
)
def test_window_times_become_intervals(start, end, first, last):
    case = read(windows=[{"start_s": start, "end_s": end}])
    assert (case.windows[0].first, case.windows[0].last) == (first, last)
    assert case.windows[0].weight == 0.001


def test_forbidden_and_overlapping_windows():
    case = read(
        windows=[
            {"first_interval": 0, "last_interval": 9, "weight": 0.5},
            {"first_interval": 5, "last_interval": 6, "weight": 0.0},
            {"first_interval": 40, "last_interval": 49, "forbidden": True},
        ]
    )
    weights = scenarios.window_weights(case)
    np.testing.assert_array_equal(weights[:10], [0.5] * 5 + [0.0] * 2 + [0.5] * 3)
    np.testing.assert_array_equal(weights[10:], np.ones(40))
    np.testing.assert_array_equal(np.flatnonzero(scenarios.forbidden_mask(case)), range(40, 50))
    np.testing.assert_array_equal(np.flatnonzero(scenarios.window_mask(case)), range(10))


def test_moving_l0_without_a_cheap_window_is_noted():
    case = read(windows=[], objective={"kind": "moving-l0"})
    assert "add [[windows]]" in case.notes[0]


def test_a_waypoint_between_nodes_moves_with_a_note():
    case = read(waypoint={"attitude_deg": [30, 45, 15], "time_s": 34.8})
    assert case.waypoint is not None
    assert case.waypoint.node == 25
    assert case.waypoint.time == pytest.approx(35.0)
    assert "moved to node 25" in case.notes[0]


def test_overrides_of_a_bundled_vehicle():
    case = read(vehicle={"use": "hypso1", "wheels": {"torque_limit_Nm": [1e-3, 1e-3, 1e-3, 2e-3]}})
    assert case.vehicle is not None
    np.testing.assert_array_equal(case.vehicle.wheels.torque_limit, [1e-3, 1e-3, 1e-3, 2e-3])
    assert case.vehicle.wheels.axes.shape == (3, 4)


def test_wheel_rows_become_columns_and_long_rows_are_noted():
    wheels = {
        "axes": [[1, 0, 0], [0, 1, 0], [1, 1, 1]],
        "inertia_kgm2": 1e-4,
        "torque_limit_Nm": 1e-3,
        "speed_limit_rad_s": 500,
    }
    case = read(
        vehicle={"inertia_kgm2": (0.1 * np.eye(3)).tolist(), "wheels": wheels},
        initial={"attitude_deg": [0, 0, 0], "wheel_speed_rad_s": [500, -500, 0]},
    )
    assert case.vehicle is not None
    np.testing.assert_allclose(case.vehicle.wheels.axes[:, 2], np.full(3, 3**-0.5))
    assert "wheel axis 3" in case.notes[0]
    fast = {"attitude_deg": [0, 0, 0], "wheel_speed_rad_s": [501, 0, 0]}
    with pytest.raises(ScenarioError, match="speed limit"):
        read(vehicle=case.document["vehicle"], initial=fast)


def test_a_vehicle_file_lies_beside_the_scenario(tmp_path):
    vehicle = 'name = "box"\ninertia_kgm2 = [[0.1,0,0],[0,0.1,0],[0,0,0.1]]\n[wheels]\n'
    vehicle += "axes = [[1,0,0],[0,1,0],[0,0,1]]\ninertia_kgm2 = 1e-4\ntorque_limit_Nm = 1e-3\n"
    (tmp_path / "box.toml").write_text(vehicle)
    text = scenarios.text("hypso1-90-45-15").replace('use = "hypso1"', 'file = "box.toml"')
    text = text.replace("wheel_speed_rad_s = [0.0, 0.0, 0.0, 0.0]", "")
    path = tmp_path / "mine.toml"
    path.write_text(text)
    case = scenarios.load(str(path))
    assert case.vehicle is not None
    assert (case.vehicle.name, case.vehicle.wheels.count) == ("box", 3)
    again = scenarios.replace(case, {"solver.starts": 8})
    assert again.vehicle is not None
    assert again.vehicle.name == "box"

    (tmp_path / "box.toml").write_text(vehicle.replace("torque_limit_Nm", "torque_limit"))
    with pytest.raises(ScenarioError, match=r"box\.toml: \[wheels\] torque_limit = .*limit_Nm'"):
        scenarios.load(path)
    (tmp_path / "box.toml").unlink()
    with pytest.raises(ScenarioError, match=r"box\.toml: cannot be read"):
        scenarios.load(path)


def test_forbidden_windows_work_for_toy_systems():
    toy = scenarios.load("double-integrator")
    window = {"start_s": 2.0, "end_s": 3.0, "forbidden": True}
    case = scenarios.replace(toy, {"windows": [window]})
    np.testing.assert_array_equal(np.flatnonzero(scenarios.forbidden_mask(case)), range(40, 61))
