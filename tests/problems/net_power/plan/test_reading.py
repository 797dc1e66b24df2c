"""Plans are read and checked: times, attitudes, order, sight."""

import dataclasses
import math
import tomllib

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxatt.environment import epoch, toward
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.light import Light
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.orbit_frame import orbit_frame
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.reading.plan import read_tasks
from jaxatt.problems.net_power.plan.task import goal
from jaxatt.problems.net_power.pose import Pose, angle_between, product
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.orbit import read_orbit
from jaxatt.problems.reading.vehicles import load_vehicle
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import bundled

DOCUMENT = tomllib.loads(bundled.text("hypso2-orbit"))
START = Pose(np.array([0.0, 0.0, 1.0, 0.0]), np.array([-0.01, 0.02, 0.01]))
CRAFT = load_vehicle("hypso1")


def satellite(table=None, craft=CRAFT):
    """Satellite on an orbit as in the file; without one where the table is empty."""
    table = DOCUMENT["orbit"] if table is None else table
    if not table:
        return Satellite(craft, Light(1361.0))
    orbit = read_orbit(table, "test", None, [])
    flown = OrbitTask(motion_of(orbit), orbit.days)
    return Satellite(craft, Light(1361.0), orbit=flown)


def sky(flown):
    """What attitudes may be told by on its orbit."""
    orbit = flown.orbit
    return Sky() if orbit is None else Sky("inertial", orbit.motion, orbit.days)


def read(document, table=None, **changes):
    full = {"orbit": DOCUMENT["orbit"] if table is None else table, **document}
    flown = satellite(table)
    return read_tasks(full, "test", flown, [], sky(flown), changes.get("initial", START))


def small(*tasks, **horizon):
    return {"horizon": horizon, "tasks": [dict(task) for task in tasks]}


HARVEST = {"mode": "harvest", "duration_s": 100.0}
IMAGE = {
    "name": "a fjord",
    "mode": "image",
    "duration_s": 60.0,
    "attitude_quaternion": [0.0, 1.0, 0.0, 0.0],
    "rate_deg_s": [0.0, -0.754, 0.0],
}


def test_table_5_1():
    tasks = read(DOCUMENT)
    assert len(tasks) == 20
    harvests = [task for task in tasks if task.searched]
    assert [task.duration for task in harvests] == [
        100, 40, 60, 20, 310, 388, 4380, 40, 60, 304,
    ]  # fmt: skip
    assert [task.intervals for task in harvests] == [50, 20, 30, 10, 155, 194, 2190, 20, 30, 152]
    assert tasks[-1].end == 6576.0
    # Printed quaternions have three digits: all are scaled to unit length.
    for task in tasks:
        if task.pose is not None:
            assert np.linalg.norm(task.pose.q_ib) == pytest.approx(1.0, abs=1e-15)
    assert goal(tasks, 0).name == "Svalbard"
    assert goal(tasks, 19) is None


def test_as_printed_the_perigee_puts_the_targets_out_of_sight():
    printed = {**DOCUMENT["orbit"], "argument_of_periapsis_deg": 213.7547}
    with pytest.raises(ScenarioError, match=r'no. 2 "Svalbard" target_deg .* out of sight: .*-\d'):
        read({"tasks": DOCUMENT["tasks"]}, printed)


def test_sight_names_angle_and_time():
    with pytest.raises(ScenarioError) as error:
        read(small(HARVEST, {**IMAGE, "target_deg": [0.0, 0.0]}))
    assert "deg above its horizon at 09:3" in str(error.value)
    assert "at least 0 deg are asked for" in str(error.value)
    least = {**small(HARVEST, {**IMAGE, "target_deg": [78.0, 15.0]}), "plan": {}}
    read(least)
    least["plan"]["least_elevation_deg"] = 60.0
    with pytest.raises(ScenarioError, match="at least 60 deg are asked for"):
        read(least)


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (small(HARVEST, {**IMAGE, "start_s": 90.0}), r'"a fjord" start_s = 90.0: overlaps.* 10 s'),
        (small(HARVEST, {**IMAGE, "start": "09:32:31"}), r"overlaps: it begins at 09:32:31, 20 s"),
        (small({**HARVEST, "start_s": -5.0}), r"start_s = -5.0: overlaps.*the plan begins"),
        (small(HARVEST, {**IMAGE, "start_s": 130.0}), r"leaves a gap of 30 s"),
        (small(HARVEST, IMAGE, horizon_s=120.0), r"leaves the horizon: it ends at 09:33:51, 40 s"),
        (small(HARVEST, IMAGE, horizon_s=120.0), r"end earlier, or raise \[horizon\] horizon_s"),
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
        (small(HARVEST, {**IMAGE, "load_W": -1.0}), r"load_W = -1.0: must be at least 0"),
        ({"tasks": []}, r"must be a list of tables"),
    ],
)
def test_errors_name_the_task_and_the_mend(document, words):
    with pytest.raises(ScenarioError, match=words):
        read(document)


def test_without_an_orbit():
    with pytest.raises(ScenarioError, match="there is no orbit"):
        read(small(HARVEST, {**IMAGE, "frame": "orbit"}), {})
    with pytest.raises(ScenarioError, match="nobody knows where the Earth is"):
        read(small(HARVEST, {**IMAGE, "target_deg": [60.0, 0.0]}), {})
    with pytest.raises(ScenarioError, match="the plan has no epoch"):
        read(small({"mode": "harvest", "end": "00:01:30"}), {})


def test_loads_are_those_of_the_mode():
    craft = dataclasses.replace(CRAFT, loads={"harvest": 13.5, "image": 29.5})
    document = small(HARVEST, IMAGE, HARVEST, {**IMAGE, "load_W": 3.0})
    tasks = read_tasks(document, "test", satellite({}, craft), [], Sky())
    assert [task.load for task in tasks] == [13.5, 29.5, 13.5, 3.0]


def test_orbit_frame_turns_with_the_orbit():
    """The attitude of the orbit frame at the task's start, and its rate, which goes on."""
    flown = satellite().orbit
    task = {
        "mode": "communicate",
        "frame": "orbit",
        "attitude_deg": [90.0, 0.0, 0.0],
        "duration_s": 9.0,
    }
    pose = read(small(HARVEST, task))[1].pose
    motion = np.sqrt(3.986e14 / 6905.1e3**3)
    # After 90 deg about x, the orbit frame's y axis is the body's -z axis.
    np.testing.assert_allclose(pose.omega_ib, [0.0, 0.0, motion], atol=3e-6)
    later, now = orbit_frame(flown, 109.0), orbit_frame(flown, 100.0)
    tilt = product(later.q_ib * np.array([1.0, -1.0, -1.0, -1.0]), pose.after(9.0).q_ib)
    np.testing.assert_allclose(np.abs(tilt), [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], atol=1e-5)
    assert angle_between(now.q_ib, later.q_ib) == pytest.approx(9.0 * motion, rel=3e-3)


def test_a_pose_turns_about_its_body_axis():
    pose = Pose(np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, math.radians(3.0), 0.0]))
    half = math.radians(45.0)
    np.testing.assert_allclose(
        pose.after(30.0).q_ib, [math.cos(half), 0.0, math.sin(half), 0.0], atol=1e-15
    )


def test_the_clock_goes_over_midnight():
    table = {**DOCUMENT["orbit"], "epoch": "2023-03-14T23:59:00Z"}
    days = epoch.days_since_j2000(epoch.parse(table["epoch"]))
    image = {key: value for key, value in IMAGE.items() if key != "duration_s"}
    document = small({"mode": "harvest", "end": "00:01:30"}, {**image, "end": "00:02:30"})
    tasks = read(document, table)
    assert [task.duration for task in tasks] == [150.0, 60.0]
    assert clock_text(tasks[1].start, days) == "00:01:30"


def test_a_task_points_along_directions():
    """As asked in the middle of the task, and at a constant rate before and after."""
    flown = satellite()
    aims = {
        "align": {"body": [0.0, 0.0, 1.0], "toward": "nadir"},
        "constrain": {"body": [1.0, 0.0, 0.0], "toward": "velocity"},
    }
    plain = {"mode": "image", "duration_s": 60.0, **aims}
    for told, rests in (("track", "orbit"), ("orbit", "orbit"), ("inertial", "inertial")):
        (_, task) = read(small(HARVEST, {**plain, "rate": told}))
        for time in (0.0, 30.0, 60.0):
            pose = task.pose.after(time)
            frame = orbit_frame(flown.orbit, task.start + (time if rests == "orbit" else 30.0))
            away = angle_between(pose.q_ib, frame.q_ib)
            assert away < (1e-9 if time == 30.0 else 1e-3)
        turning = np.linalg.norm(task.pose.omega_ib)
        assert (turning > 1e-3) == (rests == "orbit")
    held = read(small(HARVEST, {"mode": "communicate", "duration_s": 60.0, **aims}))[1].pose
    np.testing.assert_allclose(held.omega_ib, 0.0, atol=1e-15)


def test_directions_that_leave_a_task_are_told_and_refused():
    svalbard = dict(DOCUMENT["tasks"][1], mode="communicate")
    for key in ("attitude_quaternion", "target_deg"):
        svalbard.pop(key)
    latitude, longitude = DOCUMENT["tasks"][1]["target_deg"]
    site = {"toward": "site", "latitude_deg": latitude, "longitude_deg": longitude}
    svalbard["align"] = {"body": [0.0, 0.0, 1.0], **site}
    svalbard["constrain"] = {"body": [1.0, 0.0, 0.0], "toward": "velocity"}
    document = {"horizon": {}, "tasks": [dict(DOCUMENT["tasks"][0]), svalbard]}
    flown = satellite()
    whole = {"orbit": DOCUMENT["orbit"], **document}
    notes = []
    still = read_tasks(whole, "test", flown, notes, sky(flown), START)[1]
    (note,) = notes
    assert '"Svalbard" points as asked in its middle' in note and "deg away" in note
    svalbard["rate"] = "track"
    turning = read_tasks(whole, "test", flown, [], sky(flown), START)[1]
    aim = toward.ToSite(flown.orbit.motion, flown.orbit.days, *np.radians([78.23, 15.39]), 0.0)

    def off(task, time):
        sight = np.array(aim.at(jnp.asarray(task.start + time)))
        turn = Rotation.from_quat(task.pose.after(time).q_ib, scalar_first=True)
        return np.linalg.norm(np.cross(turn.apply([0.0, 0.0, 1.0]), sight / np.linalg.norm(sight)))

    for task in (still, turning):
        assert off(task, 0.5 * task.duration) < 1e-7
    assert off(turning, 0.0) < 0.5 * off(still, 0.0) and off(still, 0.0) > 0.1
    svalbard["rate_deg_s"] = [0.0, 0.1, 0.0]
    with pytest.raises(ScenarioError, match="given beside rate_deg_s"):
        read(document)
    svalbard.pop("rate_deg_s")
    svalbard["align"]["latitude_deg"] = -60.0
    with pytest.raises(ScenarioError, match="out of sight"):
        read(document)
    with pytest.raises(ScenarioError, match="needs an orbit"):
        read(
            small(
                HARVEST,
                {
                    "mode": "image",
                    "duration_s": 9.0,
                    "align": svalbard["align"],
                    "constrain": svalbard["constrain"],
                },
            ),
            {},
        )
