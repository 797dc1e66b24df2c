"""The bundled cases, and what a user does with them first."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

NAMES = (
    "double-integrator",
    "eseo-1",
    "eseo-1-keep-out",
    "eseo-2",
    "eseo-3",
    "hypso1-45-0-0",
    "hypso1-75-50-15",
    "hypso1-90-0-0",
    "hypso1-90-0-0-free",
    "hypso1-90-45-15",
    "hypso1-90-45-15-failed-wheel",
    "hypso1-90-45-15-keep-out",
    "hypso1-90-45-15-perturbed",
    "hypso1-ground-site",
    "hypso1-netpower",
    "hypso1-path",
    "hypso1-path-two",
    "hypso1-sun-free-roll",
    "hypso1-tle-90-45-15",
    "hypso2-orbit",
    "minimum-time-180",
    "minimum-time-zero-band",
    "mrp-k3",
    "mrp-k3-2.5rad",
    "mrp-k3-rk4",
    "mrp-k4",
    "mrp-k4-2.5rad",
    "mrp-k4-rk4",
    "mrp-k5",
    "mrp-k5-2.5rad",
    "mrp-k5-rk4",
    "mtq-free-time",
    "van-der-pol",
)
EARNING = ("hypso1-netpower", "hypso2-orbit", "mtq-free-time")
SPARSE = tuple(name for name in NAMES if not name.startswith("m") and name not in EARNING)
TARGETS = {
    "hypso1-45-0-0": [(45, 0, 0)],
    "hypso1-75-50-15": [(75, 50, 15)],
    "hypso1-90-0-0": [(90, 0, 0)],
    "hypso1-90-45-15": [(90, 45, 15)],
    "hypso1-90-45-15-keep-out": [(90, 45, 15)],
    "hypso1-90-45-15-perturbed": [(90, 45, 15)],
    "hypso1-path": [(0, 0, 0)],
    "hypso1-path-two": [(30, 45, 15), (0, 0, 0)],
}


def rotation(angles_deg):
    """Rz(psi) Ry(theta) Rx(phi), written out independently of the quaternion formula."""
    phi, theta, psi = np.deg2rad(np.array(angles_deg, dtype=float))
    rx = [[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]]
    ry = [[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]]
    rz = [[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]]
    return np.array(rz) @ np.array(ry) @ np.array(rx)


def matrix(quaternion):
    scalar, vector = quaternion[0], np.array(quaternion[1:])
    cross = np.array(
        [[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]]
    )
    return np.eye(3) + 2.0 * scalar * cross + 2.0 * cross @ cross


def test_the_catalog_lists_every_case_with_one_line():
    assert scenarios.names() == NAMES
    titles = scenarios.titles()
    assert tuple(titles) == NAMES
    assert all(title and "\n" not in title for title in titles.values())


@pytest.mark.parametrize("name", SPARSE)
def test_every_case_loads_and_says_where_it_comes_from(name):
    case = scenarios.load(name)
    assert case.name == name
    if name.startswith("eseo"):
        assert "Kristiansen and Gravdahl (2023)" in case.source
        assert len(case.notes) == 1 and "was normalised" in case.notes[0]  # as printed
        return
    assert "Schaanning (2021)" in case.source
    if name.endswith("failed-wheel"):
        assert len(case.notes) == 1 and "wheel 2 has failed" in case.notes[0]
    else:
        assert case.notes == ()
    assert case.solver.starts == (64 if case.system == scenarios.SPACECRAFT else 16)
    assert case.solver.seed == 0
    assert case.objective.kind == "l0"
    assert case.objective.terminal == "reach"


@pytest.mark.parametrize("name", TARGETS)
def test_the_hypso1_cases_hold_the_printed_values(name):
    case = scenarios.load(name)
    assert case.vehicle is not None
    assert case.orbit is not None
    assert case.vehicle.name == "hypso1"
    assert case.orbit.semi_major_axis == pytest.approx(6852.2e3)
    assert case.orbit.raan == pytest.approx(np.deg2rad(280.0))
    assert case.horizon.step == pytest.approx(1.4)
    assert case.horizon.coast_intervals == 20
    weights = case.objective
    assert (weights.rate_weight, weights.attitude_weight) == (1e6, 1e2)
    assert (weights.sparsity_weight, weights.epsilon) == (1e1, 1e-8)
    assert len(case.targets) == len(TARGETS[name])
    for target, angles in zip(case.targets, TARGETS[name], strict=True):
        np.testing.assert_allclose(matrix(target.q_ob), rotation(angles), atol=1e-14)
        assert target.attitude_tolerance == pytest.approx(np.deg2rad(0.01))
        assert target.rate_tolerance == 1e-5


@pytest.mark.parametrize("name", [name for name in TARGETS if "keep-out" not in name])
def test_windows_are_the_printed_ones(name):
    case = scenarios.load(name)
    inside = [*range(7, 15), *range(35, 43)] if name == "hypso1-path" else list(range(20, 31))
    weights = scenarios.window_weights(case)
    assert weights.shape == (50,)
    np.testing.assert_array_equal(np.flatnonzero(weights == 0.001), inside)
    assert set(weights) == {0.001, 1.0}
    np.testing.assert_array_equal(np.flatnonzero(scenarios.window_mask(case)), inside)
    assert not scenarios.forbidden_mask(case).any()


def test_the_perturbed_case_and_the_path():
    perturbed = scenarios.load("hypso1-90-45-15-perturbed")
    assert perturbed.disturbances.gravity_gradient
    assert perturbed.disturbances.sinusoidal_torque == 1e-4
    assert perturbed.horizon.substeps == 4
    path = scenarios.load("hypso1-path")
    assert path.waypoint is not None
    assert (path.waypoint.time, path.waypoint.node) == (35.0, 25)
    np.testing.assert_allclose(matrix(path.waypoint.q_ob), rotation((30, 45, 15)), atol=1e-14)


@pytest.mark.parametrize(
    ("name", "duration", "start", "tolerance"),
    [("double-integrator", 5.0, [1.0, 1.0], 1e-6), ("van-der-pol", 10.0, [0.0, 1.0], 1e-5)],
)
def test_the_toy_systems(name, duration, start, tolerance):
    case = scenarios.load(name)
    assert case.system == name
    assert case.vehicle is None
    assert case.orbit is None
    assert (case.horizon.duration, case.horizon.intervals) == (duration, 100)
    np.testing.assert_array_equal(case.initial.state, start)
    np.testing.assert_array_equal(case.targets[0].state, [0.0, 0.0])
    assert (case.control.limit, case.targets[0].state_tolerance) == (1.0, tolerance)


def test_printed_values_stand_beside_the_case():
    printed = scenarios.load("hypso1-90-45-15").printed
    assert printed["table"] == "6.4"
    assert printed["l0"]["iterations"] == 497
    assert printed["moving-l0"]["active_outside_windows"] == 1
    assert printed["l1"]["cpu_time_nlp_s"] == 5.131
    rows = scenarios.load("hypso1-45-0-0").printed["rows"]
    assert [row["iterations"] for row in rows] == [953, 559, 14, 1757, 1473, 1001, 25, 41]
    assert [r["active_intervals"] for r in scenarios.load("hypso1-90-0-0").printed["rows"]] == [
        2,
        3,
        3,
    ]


def test_the_printed_text_is_a_file_to_start_from(tmp_path):
    text = scenarios.text("hypso1-90-45-15")
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("[90.0, 45.0, 15.0]", "[180.0, -20.0, 359.0]"))
    case = scenarios.load(path)
    np.testing.assert_allclose(matrix(case.targets[0].q_ob), rotation((180, -20, 359)), atol=1e-14)


def test_a_misspelt_case_suggests_the_near_one():
    with pytest.raises(ScenarioError, match="did you mean 'hypso1-90-45-15'"):
        scenarios.load("hypso1-90-45-16")
    with pytest.raises(ScenarioError, match=r"bundled: .*hypso1-90-45-15"):
        scenarios.text("nothing-like-it")


def test_replace_reads_the_document_again():
    case = scenarios.load("hypso1-90-45-15")
    changed = scenarios.replace(
        case,
        {
            "objective.kind": "moving-l0",
            "solver.seed": 7,
            "target.attitude_quaternion": np.array([0.0, 1.0, 0.0, 0.0]),
            "vehicle.wheels.torque_limit_Nm": 1.5e-3,
            "windows.0.weight": 0.5,
            "disturbances.gravity_gradient": True,
            "orbit.gravitational_parameter_m3_s2": None,
        },
    )
    assert (changed.objective.kind, changed.solver.seed) == ("moving-l0", 7)
    np.testing.assert_array_equal(changed.targets[0].q_ob, [0, 1, 0, 0])
    assert changed.vehicle is not None
    np.testing.assert_array_equal(changed.vehicle.wheels.torque_limit, np.full(4, 1.5e-3))
    assert changed.windows[0].weight == 0.5
    assert changed.disturbances.gravity_gradient
    assert case.objective.kind == "l0"
    assert case.windows[0].weight == 0.001
    assert not case.disturbances.gravity_gradient


def test_replace_a_leg_and_refuse_what_does_not_exist():
    case = scenarios.load("hypso1-path-two")
    changed = scenarios.replace(case, {"legs.1.attitude_deg": [0, 0, 90]})
    np.testing.assert_allclose(matrix(changed.targets[1].q_ob), rotation((0, 0, 90)), atol=1e-14)
    with pytest.raises(ScenarioError, match="no '2'"):
        scenarios.replace(case, {"legs.2.attitude_deg": [0, 0, 90]})
    with pytest.raises(ScenarioError, match="did you mean 'kind'"):
        scenarios.replace(case, {"objective.kinds": "l1"})
