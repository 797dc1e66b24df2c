"""Slews between cones, flown again by SciPy between the nodes too."""

import functools

import numpy as np
import pytest
from references import reflight

import jaxatt
from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.studies.baseline import fly_pd_phases

PIECES = 12
SHORT = {
    "limits.body_rate_deg_s": 90.0,
    "horizon.intervals": 25,
    "horizon.coast_intervals": 2,
    "windows": None,
    "solver.starts": 4,
}


def short(name="hypso1-90-45-15", **changes):
    return scenarios.replace(scenarios.load(name), {**SHORT, **changes})


@functools.cache
def unconstrained(attitude=(90.0, 45.0, 15.0)):
    scenario = short(**{"target.attitude_deg": list(attitude)})
    result = jaxatt.solve(scenario)
    assert result.reached
    return scenario, result, reflight.refly(scenario, result, PIECES)[0][1]


def unit(vector):
    return vector / np.linalg.norm(vector)


OUT_OF_THE_WAY = [
    {
        "name": f"needle {k}",
        "boresight": [1.0, 0.0, 0.0],
        "direction_inertial": direction,
        "half_angle_deg": 0.01,
    }
    for k, direction in enumerate(([0.2, 0.3, -0.9], [0.4, -0.1, -0.9]))
]
"""Beside one cone, so that all these slews have three and compile once."""

AWAY = {**OUT_OF_THE_WAY[0], "name": "needle 2", "direction_inertial": [0.1, 0.2, -0.9]}


def random_cone(rng, flight):
    """A keep-out cone that the flight crosses, which holds neither its start nor its end."""
    attitudes = flight.attitudes
    while True:
        boresight = unit(rng.normal(size=3))
        middle = attitudes[rng.integers(len(attitudes) // 3, 2 * len(attitudes) // 3)]
        direction = unit(middle @ boresight + 0.1 * rng.normal(size=3))
        ends = min(
            np.arccos(np.clip(attitudes[k] @ boresight @ direction, -1.0, 1.0)) for k in (0, -1)
        )
        if ends > np.deg2rad(30.0):
            return boresight, direction, 0.6 * ends


def keep_out(name, boresight, direction, half_angle):
    return {
        "name": name,
        "boresight": list(boresight),
        "direction_inertial": list(direction),
        "half_angle_deg": float(np.rad2deg(half_angle)),
    }


def test_slews_go_round_random_cones():
    _, _, crossing = unconstrained()
    cone = random_cone(np.random.default_rng(1), crossing)
    assert reflight.cone_angle(crossing, *cone[:2]).min() < cone[2]
    scenario = short(keep_out=[keep_out("camera", *cone), *OUT_OF_THE_WAY])
    result = jaxatt.solve(scenario)
    assert result.reached, result.phases[0].failure_reason
    reflight.assert_reached(scenario, result)
    flown = reflight.refly(scenario, result, PIECES)[0][1]
    nearest = reflight.cone_angle(flown, *cone[:2]).min()
    assert nearest >= cone[2] * (1 - 2e-6)
    found = result.summary()["pointing"][0]
    assert found["satisfied"] and found["kind"] == "keep-out" and found["name"] == "camera"
    np.testing.assert_allclose(found["nearest_deg"], np.rad2deg(nearest), atol=0.02)
    assert "keep-out camera" in str(result) and "nearest" in str(result)
    dataset = result.to_dataset()
    np.testing.assert_allclose(
        np.rad2deg(dataset.cone_angle.values[: 25 * 20 + 1, 0].min()), found["nearest_deg"]
    )


def test_a_slew_goes_round_a_direction_that_moves():
    _, _, crossing = unconstrained()
    sight = crossing.v / np.linalg.norm(crossing.v, axis=-1, keepdims=True)
    assert np.degrees(np.arccos(sight[0] @ sight[-1])) > 1.0

    def angles(flight, boresight):
        ahead = flight.v / np.linalg.norm(flight.v, axis=-1, keepdims=True)
        seen = (flight.attitudes @ boresight * ahead).sum(axis=-1)
        return np.arccos(np.clip(seen, -1.0, 1.0))

    for boresight in map(unit, np.random.default_rng(12).normal(size=(500, 3))):
        off = angles(crossing, boresight)
        half = 0.7 * min(off[0], off[-1])
        if half > 0.3 and off.min() < 0.7 * half:
            break
    assert off.min() < 0.7 * half
    cone = {"name": "camera", "boresight": list(boresight), "toward": "velocity"}
    cone["half_angle_deg"] = float(np.rad2deg(half))
    scenario = short(keep_out=[cone, *OUT_OF_THE_WAY])
    result = jaxatt.solve(scenario)
    assert result.reached, result.phases[0].failure_reason
    nearest = angles(reflight.refly(scenario, result, PIECES)[0][1], boresight).min()
    assert nearest >= half * (1 - 2e-6)
    found = result.summary()["pointing"][0]
    np.testing.assert_allclose(found["nearest_deg"], np.rad2deg(nearest), atol=0.02)


def test_a_cone_that_does_not_bind_changes_nothing():
    _, plain, crossing = unconstrained()
    far = -crossing.attitudes[0] @ np.array([0.0, 0.0, 1.0])
    scenario = short(keep_out=[keep_out("radiator", [0.0, 0.0, 1.0], far, 0.3)])
    result = jaxatt.solve(scenario)
    np.testing.assert_array_equal(result.phases[0].controls, plain.phases[0].controls)
    assert result.summary()["pointing"][0]["satisfied"]


def test_a_wall_of_cones_is_named_as_the_obstacle():
    _, _, crossing = unconstrained()
    boresight = np.array([0.0, 0.0, 1.0])
    begin, end = (crossing.attitudes[k] @ boresight for k in (0, -1))
    assert np.arccos(begin @ end) > np.deg2rad(60.0)
    # Three cones about the plane between start and end that overlap: no way leads through.
    pole, meridian = unit(begin - end), unit(begin + end)
    across = np.cross(pole, meridian)
    wall = [np.cos(a) * meridian + np.sin(a) * across for a in np.deg2rad([60.0, 180.0, 300.0])]
    cones = [keep_out(f"wall {k}", boresight, d, np.deg2rad(61.0)) for k, d in enumerate(wall)]
    result = jaxatt.solve(short(keep_out=cones))
    assert not result.reached
    assert (
        "keep-out wall" in result.phases[0].failure_reason
        and "is broken" in result.phases[0].failure_reason
    )
    assert not all(entry["satisfied"] for entry in result.summary()["pointing"])


def test_half_a_turn_past_a_cone_and_slow_enough():
    scenario, _, crossing = unconstrained((180.0, 0.0, 0.0))
    peak = np.abs(crossing.omega).max()
    cone = random_cone(np.random.default_rng(5), crossing)
    scenario = short(
        keep_out=[keep_out("camera", *cone), *OUT_OF_THE_WAY],
        **{
            "target.attitude_deg": [180.0, 0.0, 0.0],
            "limits.body_rate_deg_s": float(np.rad2deg(1.5 * peak)),
        },
    )
    result = jaxatt.solve(scenario)
    assert result.reached, result.phases[0].failure_reason
    flown = reflight.refly(scenario, result, PIECES)[0][1]
    assert reflight.cone_angle(flown, *cone[:2]).min() >= cone[2] * (1 - 2e-6)
    assert np.abs(flown.omega).max() <= 1.5 * peak * (1 + 2e-6)


def test_a_boresight_is_kept_within_a_cone():
    _, _, crossing = unconstrained()
    rng = np.random.default_rng(9)
    for boresight in rng.normal(size=(500, 3)):
        boresight = unit(boresight)
        begin, middle, end = (crossing.attitudes[k] @ boresight for k in (0, PIECES * 12, -1))
        between = unit(begin + end)
        bulge = unit(middle - (middle @ between) * between)
        # To the side that the way bulges away from, so that its middle is the farthest.
        direction = 0.5 * between - np.sqrt(0.75) * bulge
        half = np.arccos(min(begin @ direction, end @ direction)) + np.deg2rad(3.0)
        farthest = reflight.cone_angle(crossing, boresight, direction).max()
        if farthest > half + np.deg2rad(3.0):
            break
    assert farthest > half
    cone = keep_out("antenna", boresight, direction, half)
    scenario = short(keep_in=[cone], keep_out=OUT_OF_THE_WAY)
    result = jaxatt.solve(scenario)
    assert result.reached, result.phases[0].failure_reason
    flown = reflight.refly(scenario, result, PIECES)[0][1]
    assert reflight.cone_angle(flown, boresight, direction).max() <= half * (1 + 2e-6)
    found = next(e for e in result.summary()["pointing"] if e["name"] == "antenna")
    assert found["kind"] == "keep-in" and found["farthest_deg"] <= found["allowed_deg"]


def test_a_rate_too_slow_for_the_horizon_is_named_as_the_obstacle():
    _, _, crossing = unconstrained()
    limit = float(np.rad2deg(0.3 * np.abs(crossing.omega).max()))
    result = jaxatt.solve(
        short(keep_out=[*OUT_OF_THE_WAY, AWAY], **{"limits.body_rate_deg_s": limit})
    )
    assert not result.reached
    assert "body rate is broken: fastest" in result.phases[0].failure_reason
    assert result.summary()["pointing"][-1]["kind"] == "body-rate"


def test_certificates_and_feedback_baselines_know_of_cones():
    scenario = short("hypso1-90-45-15-keep-out")
    with pytest.raises(scenarios.ScenarioError, match=r"\[\[keep_out\]\]"):
        jaxatt.certify(scenario)
    (flown,) = fly_pd_phases(scenario)
    assert flown.errors["attitude"] < np.pi


def test_legs_one_after_another_are_watched_each(tmp_path):
    cone = {**AWAY, "name": "dish", "half_angle_deg": 5.0}
    result = jaxatt.solve(short("hypso1-path-two", keep_out=[cone]))
    assert result.reached
    entries = result.summary()["pointing"]
    assert [entry["leg"] for entry in entries if entry["name"] == "dish"] == [1, 2]
    written = {path.name for path in result.save(tmp_path)}
    assert {"pointing.png", "result.nc", "summary.json"} <= written
    assert "keep-out dish" in str(result)


def test_judges_see_between_the_nodes():
    """A flight whose nodes keep to a cone and whose way between them does not is not reached."""
    _, plain, crossing = unconstrained()
    boresight = np.array([0.0, 0.0, 1.0])
    # The direction where the boresight is in the middle of an interval, halfway.
    middle = PIECES * 12 + PIECES // 2
    direction = crossing.attitudes[middle] @ boresight
    angle = reflight.cone_angle(crossing, boresight, direction)
    assert angle.min() < 0.5 * angle[::PIECES].min()
    half = 0.8 * angle[::PIECES].min()
    task = build_slew(short(keep_out=[keep_out("slit", boresight, direction, half)]))
    assert isinstance(task, SlewTask)
    verdict, _ = task.verify(plain.phases[0].controls[None])
    assert verdict.arrives.all() and not verdict.reached.any()
    assert verdict.margin_violation[0] > 0.5
