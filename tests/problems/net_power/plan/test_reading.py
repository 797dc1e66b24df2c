"""Plans are read and checked: times, attitudes, order, sight."""

import copy
import math
import tomllib

import numpy as np
import pytest

from jaxatt.environment import epoch
from jaxatt.problems.net_power.plan.reading.plan import read_plan
from jaxatt.problems.net_power.plan.reading.times import clock_text
from jaxatt.problems.net_power.plan.sight import check_sights
from jaxatt.problems.net_power.plan.task import Pose
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.settings import read_orbit
from jaxatt.problems.surroundings import elements_of
from jaxatt.scenarios import bundled

DOCUMENT = tomllib.loads(bundled.text("hypso2-orbit"))
ORBIT = read_orbit(DOCUMENT["orbit"], "test")
START = Pose(np.array([0.0, 0.0, 1.0, 0.0]), np.array([-0.01, 0.02, 0.01]))


def read(document, **changes):
    options = {"initial": START, "days": ORBIT.days, "notes": [], **changes}
    return read_plan(document, "test", **options)


def small(*tasks, **plan):
    return {"plan": plan, "tasks": [dict(task) for task in tasks]}


HARVEST = {"mode": "harvest", "duration_s": 100.0}
IMAGE = {
    "name": "a fjord",
    "mode": "image",
    "duration_s": 60.0,
    "attitude_quaternion": [0.0, 1.0, 0.0, 0.0],
    "rate_deg_s": [0.0, -0.754, 0.0],
}


def test_table_5_1():
    plan = read(DOCUMENT)
    assert len(plan.tasks) == 20
    harvests = [task for task in plan.tasks if task.searched]
    assert [task.duration for task in harvests] == [
        100, 40, 60, 20, 310, 388, 4380, 40, 60, 304,
    ]  # fmt: skip
    assert [task.intervals for task in harvests] == [50, 20, 30, 10, 155, 194, 2190, 20, 30, 152]
    assert plan.duration == 6576.0
    # Printed quaternions have three digits: all are scaled to unit length.
    for task in plan.tasks:
        if task.pose is not None:
            assert np.linalg.norm(task.pose.q_ib) == pytest.approx(1.0, abs=1e-15)
    assert plan.goal(0).name == "Svalbard"
    assert plan.goal(19) is None


def test_all_targets_of_table_5_1_are_in_sight():
    check_sights(
        read(DOCUMENT), elements_of(ORBIT), ORBIT.gravitational_parameter, ORBIT.days, "test"
    )


def test_as_printed_the_perigee_puts_them_out_of_sight():
    changed = copy.deepcopy(DOCUMENT["orbit"])
    changed["argument_of_periapsis_deg"] = 213.7547
    orbit = read_orbit(changed, "test")
    with pytest.raises(ScenarioError, match=r'no. 2 "Svalbard" target_deg .* out of sight: .*-\d'):
        check_sights(
            read(DOCUMENT), elements_of(orbit), orbit.gravitational_parameter, orbit.days, "test"
        )


def test_sight_names_angle_and_time():
    document = small(HARVEST, {**IMAGE, "target_deg": [0.0, 0.0]})
    with pytest.raises(ScenarioError) as error:
        check_sights(
            read(document), elements_of(ORBIT), ORBIT.gravitational_parameter, ORBIT.days, "test"
        )
    assert "deg above its horizon at 09:3" in str(error.value)
    assert "at least 0 deg are asked for" in str(error.value)


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (small(HARVEST, {**IMAGE, "start_s": 90.0}), r'"a fjord" start_s = 90.0: overlaps.* 10 s'),
        (small(HARVEST, {**IMAGE, "start": "09:32:31"}), r"overlaps: it begins at 09:32:31, 20 s"),
        (small({**HARVEST, "start_s": -5.0}), r"start_s = -5.0: overlaps.*the plan begins"),
        (small(HARVEST, {**IMAGE, "start_s": 130.0}), r"leaves a gap of 30 s"),
        (small(HARVEST, IMAGE, horizon_s=120.0), r"leaves the horizon: it ends at 09:33:51, 40 s"),
        (small(HARVEST, IMAGE, horizon_s=200.0), r"the last task ends at 09:33:51, 40 s before"),
        (small({**HARVEST, "end_s": 50.0}), r"end_s = 50.0: given beside|duration_s"),
        (small({"mode": "harvest", "end": "soon"}), r"is no time by the clock"),
        (small({"mode": "image", "duration_s": 6.0}), r"attitude_quaternion: missing"),
        (small(HARVEST, {"mode": "idle", "duration_s": 6.0}), r"add the attitude to wait in"),
        (small({**HARVEST, "rate_deg_s": [0.0, 0.0, 0.0]}), r"a harvest ends in the attitude"),
        (
            small(HARVEST, {**IMAGE, "mode": "communicate"}),
            r"holds its attitude, only image turns",
        ),
        (small(IMAGE), r"cannot be reached: the plan begins 180 deg"),
        (
            small(HARVEST, IMAGE, {**IMAGE, "name": "a lake"}),
            r'"a lake" start: cannot be reached: "a fjord" ends 45.24 deg and 0 deg/s away',
        ),
        (small(HARVEST, IMAGE, {"mode": "idle", "duration_s": 5.0}), r"ends 0 deg and 0.754 deg/s"),
        (small(HARVEST, {**IMAGE, "target_deg": [98.0, 0.0]}), r"is no place on the Earth"),
        (small(HARVEST, {**IMAGE, "frame": "orbit"}), r"there is no orbit"),
        (small(HARVEST, least_charge_percent=20.0), r"the vehicle has no battery"),
        ({"tasks": []}, r"must be a list of tables"),
    ],
)
def test_errors_name_the_task_and_the_mend(document, words):
    with pytest.raises(ScenarioError, match=words):
        read(document)


def test_floor_above_the_capacity():
    document = small(HARVEST, least_charge_Wh=80.0)
    with pytest.raises(ScenarioError, match="more than the capacity of 75 Wh"):
        read(document, capacity=75 * 3600.0)
    assert read(
        small(HARVEST, least_charge_percent=40.0), capacity=100.0
    ).least_charge == pytest.approx(40.0)


def test_orbit_frame_turns_with_the_orbit():
    """An attitude in the orbit frame goes on turning with it."""
    frame = Pose(np.array([0.6, 0.0, 0.8, 0.0]), np.array([0.0, -1e-3, 0.0]))
    attitude = [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]  # about x: y of the orbit is -z of it
    task = {"mode": "communicate", "frame": "orbit", "attitude_quaternion": attitude}
    found = read(small(HARVEST, {**task, "duration_s": 9.0}), orbit=lambda time: frame).tasks[1]
    np.testing.assert_allclose(found.pose.omega_ib, [0.0, 0.0, 1e-3], atol=1e-15)
    expected = math.sqrt(0.5) * np.array([0.6, 0.6, 0.8, -0.8])
    np.testing.assert_allclose(found.pose.q_ib, expected, atol=1e-15)


def test_a_pose_turns_about_its_body_axis():
    pose = Pose(np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, math.radians(3.0), 0.0]))
    half = math.radians(45.0)
    np.testing.assert_allclose(
        pose.after(30.0).q_ib, [math.cos(half), 0.0, math.sin(half), 0.0], atol=1e-15
    )


def test_the_clock_goes_over_midnight():
    days = epoch.days_since_j2000(epoch.parse("2023-03-14T23:59:00Z"))
    image = {key: value for key, value in IMAGE.items() if key != "duration_s"}
    document = small({"mode": "harvest", "end": "00:01:30"}, {**image, "end": "00:02:30"})
    tasks = read(document, days=days).tasks
    assert [task.duration for task in tasks] == [150.0, 60.0]
    assert clock_text(tasks[1].start, days) == "00:01:30"
