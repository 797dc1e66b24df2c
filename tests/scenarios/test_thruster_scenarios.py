"""Scenarios with thrusters: the printed data, and input that cannot be meant."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

PAIR = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("name", "intervals", "limit", "k3", "k4"),
    [
        ("eseo-1", 90, 0.195, 4.5e4 / 90, 2.295e5 / (90 * 6)),
        ("eseo-2", 90, 0.0975, 4.5e4 / 90, 2.295e5 / (90 * 6)),
        ("eseo-3", 45, 0.0975, 1.35e5 / 45, 6.885e5 / (45 * 6)),
    ],
)
def test_bundled_scenarios_hold_the_printed_data(
    name: str, intervals: int, limit: float, k3: float, k4: float
) -> None:
    case = scenarios.load(name)
    assert case.vehicle is not None and case.orbit is None
    assert case.horizon.intervals == intervals and case.horizon.duration == 30.0
    np.testing.assert_allclose(case.vehicle.thrusters.torque_limit, limit)
    np.testing.assert_allclose(np.diag(case.vehicle.inertia), [4.35, 4.337, 3.664])
    assert case.objective.sparsity_weight == pytest.approx(k3)
    assert case.objective.on_off_weight == pytest.approx(k4)
    assert (case.objective.rate_weight, case.objective.attitude_weight) == (18.4, 3920.0)


def test_printed_reference_is_normalised_with_a_note() -> None:
    case = scenarios.load("eseo-1")
    assert np.linalg.norm(case.targets[0].q_ob) == pytest.approx(1.0, abs=1e-15)
    assert any("was normalised; its norm was 1.00009" in note for note in case.notes)
    angle = 2.0 * np.arccos(abs(case.targets[0].q_ob @ case.initial.q_ob))
    assert np.degrees(angle) == pytest.approx(180.0, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"vehicle.thrusters.torque_directions": PAIR},
            r"\[vehicle.thrusters\] torque_directions .*about \+y, -y, \+z, -z",
        ),
        ({"vehicle.thrusters.torque_limit_Nm": -0.1}, "torque_limit_Nm .*greater than 0"),
        (
            {"vehicle.thrusters.minimum_on_time_s": 0.5},
            "minimum_on_time_s: 0.5 s is longer than a control interval of 0.333333 s",
        ),
        ({"vehicle.thrusters.minimum_impulse_Nms": 0.1}, "minimum_impulse_Nms: 0.51282"),
        ({"vehicle.thrusters.minimum_on_time": 0.1}, "did you mean 'minimum_on_time_s'"),
        ({"control.axes": "body"}, "thrusters are optimised one by one"),
        ({"control.quantisation": "pwm"}, "pulse-width"),
        ({"objective.design": 2}, "share one complementarity vector"),
        ({"objective.on_off_form": "other"}, "active"),
        ({"disturbances.gravity_gradient": True}, r"there is no \[orbit\]"),
        ({"waypoint": {"time_s": 15.0, "attitude_deg": [0, 0, 0]}}, "not available with thrusters"),
    ],
)
def test_bad_input_says_how_to_mend_it(changes: dict, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        scenarios.replace(scenarios.load("eseo-1"), changes)


def test_quantisation_needs_thrusters() -> None:
    with pytest.raises(ScenarioError, match="the vehicle has no thrusters"):
        scenarios.replace(scenarios.load("hypso1-90-0-0"), {"control.quantisation": "pulse-width"})
