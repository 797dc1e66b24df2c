"""A plan of four short tasks from end to end: in sequence, above a floor, together, over dates."""

import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sgp4.api import Satrec
from short_plan import DOCUMENT, short_plan

import jaxatt
from jaxatt import scenarios
from jaxatt.drawing.rendering import as_text
from jaxatt.environment.kepler import to_state
from jaxatt.environment.orbit_data.oem import read_oem
from jaxatt.environment.teme import inertial_of_teme
from jaxatt.exchange.aem_reading import read_aem
from jaxatt.multistart.driver import some_passes
from jaxatt.optimize.status import Status
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power import improve
from jaxatt.problems.net_power.answers import phase_manoeuvre, searched
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.corrected import corrected
from jaxatt.problems.net_power.plan.joint.assemble import assembled
from jaxatt.problems.net_power.plan.joint.programme import joint_programme
from jaxatt.problems.net_power.plan.joint.solve import JointAnswer
from jaxatt.problems.net_power.pose import Pose, angle_between
from jaxatt.problems.net_power.record import energy_of, net_power
from jaxatt.problems.net_power.wheels.from_law import also_from_law, held_torque
from jaxatt.problems.net_power.wheels.within_limits import keeping_to
from jaxatt.problems.surroundings import elements_of, motion_of
from jaxatt.report.export.export import export
from jaxatt.report.tables import result_table
from jaxatt.runtime.lengths import shared_length
from jaxatt.studies.plan_year import plan_year

CAPACITY = 3600.0  # [J]
TASKS = DOCUMENT["tasks"]
SIGHTLESS = {"plan.least_elevation_deg": -90.0}
"""Other dates have the targets elsewhere."""


def planned(changes=None):
    return jaxatt.solve(scenarios.from_mapping(short_plan(changes)))


def torques(plan):
    """Torques of the harvests, None for the other tasks."""
    return tuple(
        phase.series["torque_wheels"] if net_power(phase).mode == "harvest" else None
        for phase in plan.phases
    )


@pytest.fixture(scope="module")
def sequence():
    """Solved task after task; the floor is far below."""
    return planned()


@pytest.fixture(scope="module")
def together():
    return planned({"plan.joint": True})


def test_every_task_begins_where_the_one_before_ended(sequence):
    assert sequence.reached
    time = 0.0
    for before, after in zip(sequence.phases, sequence.phases[1:], strict=False):
        time += before.final_time
        assert after.start_time == pytest.approx(time)
        end, begin = before.series, after.series
        assert angle_between(end["q_ib"][-1], begin["q_ib"][0]) < 1e-9
        assert begin["charge"][0] == pytest.approx(end["charge"][-1], abs=1e-9)
        assert begin["net_energy"][0] == 0.0
    whole = energy_of(sequence.phases)
    charge = [phase.series["charge"] for phase in sequence.phases]
    assert whole.final_charge == charge[-1][-1]
    assert charge[-1][-1] - charge[0][0] == pytest.approx(whole.net, abs=1e-6)
    assert whole.least_charge == min(part.min() for part in charge)


def test_imaging_turns_at_its_rate_over_the_whole_task(sequence):
    imaging, task = sequence.phases[1], options_of(sequence.scenario).tasks[1]
    rate = np.deg2rad([0.0, -0.754, 0.0])
    q, omega = imaging.series["q_ib"], imaging.series["omega_ib"]
    np.testing.assert_allclose(omega, np.tile(rate, (len(omega), 1)), atol=1e-12)
    begun = Pose(q[0], rate)
    assert angle_between(begun.q_ib, task.pose.q_ib) < task.attitude_tolerance
    for share in (0.5, 1.0):
        node = round(share * (len(q) - 1))
        assert angle_between(q[node], begun.after(share * task.duration).q_ib) < 1e-9
    # It is the harvest before that sets the body turning.
    ended = sequence.phases[0].series["omega_ib"][-1]
    assert np.linalg.norm(ended - rate) < task.rate_tolerance


def test_each_harvest_earns_more_than_the_law(sequence):
    for phase in sequence.phases:
        gain = net_power(phase).energy.gain
        assert gain > 1.0 if net_power(phase).mode == "harvest" else abs(gain) < 1e-9


def test_the_floor_of_the_battery_binds(sequence):
    """On the way to the sun the charge dips; a floor above the dip costs energy, and lifts it.

    The programme counts what the sun gives in an interval at its end, so that its charge is behind
    by half an interval: what is held above the floor is that.
    """
    first = sequence.phases[0]
    free = first.series["charge"]
    counted = (free - 0.5 * first.step * first.series["solar_power"])[1:].min()
    floor = counted + 0.5
    held = planned({"limits.least_charge_percent": 100.0 * floor / CAPACITY})
    assert held.reached
    assert net_power(held.phases[0]).energy.least_charge >= floor
    assert held.phases[0].series["charge"].min() > free.min() + 0.1
    lost = net_power(first).energy.net - net_power(held.phases[0]).energy.net
    assert 0.02 < lost < 2.0


def test_a_floor_far_below_hinders_no_start():
    """What the sun gives moves the charge far, which must not be held back as steps are."""
    changes = {"horizon.step_s": 3.75, "vehicle.battery.capacity_Wh": 20.0, **SIGHTLESS}
    changes |= {f"tasks.{k}.duration_s": 3.0 * t["duration_s"] for k, t in enumerate(TASKS)}
    scenario = scenarios.from_mapping(short_plan(changes | {"baseline": None}))
    solved = searched(scenario, PhaseStart(), None).solved
    assert (solved.status <= int(Status.FEASIBLE)).all()
    assert (solved.claimed > 425.0).all()


def test_the_law_is_one_start_more_where_it_earns_more(sequence):
    law = options_of(sequence.scenario).baseline
    manoeuvre = phase_manoeuvre(sequence.scenario, PhaseStart())
    size = shared_length(manoeuvre.intervals)
    solved = searched(sequence.scenario, PhaseStart(), None).solved
    earned = net_power(sequence.phases[0]).energy.baseline
    poor = dataclasses.replace(solved, claimed=np.full(4, earned - 1.0))
    rich = dataclasses.replace(solved, claimed=np.full(4, earned + 1.0))
    (same,) = also_from_law([manoeuvre], [rich], law, size)
    assert same.torque is rich.torque
    assert same.law.energy.net_J[0] == pytest.approx(earned, abs=1e-6 * abs(earned))
    (found,) = also_from_law([manoeuvre], [poor], law, size)
    assert found.torque.shape == (5, *solved.torque.shape[1:])
    assert found.status[-1] <= int(Status.FEASIBLE)
    assert found.claimed[-1] > earned + 50.0


def test_torques_held_for_other_times_give_the_same_impulse():
    torque = np.random.default_rng(3).normal(size=(10, 3))
    finer = held_torque(torque, 40)
    np.testing.assert_allclose(finer, np.repeat(torque, 4, axis=0))
    np.testing.assert_allclose(held_torque(finer, 10), torque)
    np.testing.assert_allclose(held_torque(torque, 7).sum(axis=0) / 7, torque.sum(axis=0) / 10)


def test_a_floor_that_no_turn_can_hold_is_told_with_the_task_and_what_is_missing(sequence):
    floor = sequence.phases[0].series["charge"].min() + 1.0
    failed = planned({"limits.least_charge_percent": 100.0 * floor / CAPACITY})
    first = failed.phases[0]
    assert not failed.reached and not first.reached
    missing = (floor - first.series["charge"].min()) / 3600.0
    words = f"the battery falls {missing:.3g} Wh below its floor of {floor / 3600.0:.4g} Wh"
    assert words in first.failure_reason
    text = " ".join(as_text(result_table(failed), 80).split())
    assert 'Task 1 "first harvest" is not flown as asked' in text and words in text


def test_together_is_no_worse_than_in_sequence(sequence, together):
    """Three wheels without external torques leave nothing to decide together: both must agree."""
    joint = together.extra["joint"]
    assert together.reached and "met constraints and stationarity" in joint["words"]
    assert abs(joint["gain_J"]) < 1e-2
    assert joint["kept"] == (joint["gain_J"] >= -1e-6)
    earned, alone = energy_of(together.phases).net, energy_of(sequence.phases).net
    assert earned == pytest.approx(alone + joint["kept"] * joint["gain_J"], abs=1e-6)
    assert earned >= alone - 1e-6
    for phase in together.phases:
        # Of the search before, which has all starts.
        count = len(phase.starts.status)
        assert len(net_power(phase).start_energy) == len(net_power(phase).start_score) == count
    text = " ".join(as_text(result_table(together), 80).split())
    told = "kept" if joint["kept"] else "not kept"
    assert f"{joint['gain_J']:+.3f} J over the sequence ({told};" in text


@pytest.mark.parametrize("fault", ["misses", "earns less"])
def test_the_sequence_is_kept_where_the_joint_answer_is_worse(sequence, monkeypatch, fault):
    """An answer that does not arrive, and one that does but wastes energy on the way."""
    given = torques(sequence)
    if fault == "misses":
        given = tuple(None if torque is None else 0.0 * torque for torque in given)
    else:
        to_and_fro = np.zeros_like(given[0])
        to_and_fro[8:20] = 3e-4 * np.where(np.arange(12) % 2, 1.0, -1.0)[:, None]
        manoeuvre = phase_manoeuvre(sequence.scenario, PhaseStart())
        given = (corrected(manoeuvre, given[0] + to_and_fro), *given[1:])
    monkeypatch.setattr(improve, "corrected", lambda manoeuvre, torque, dipole: torque)
    answer = JointAnswer(given, (None,) * 4, Status.CONVERGED, 0.0, 0.0, 7)
    monkeypatch.setattr(improve, "solve_jointly", lambda *_, **__: answer)
    scenario = scenarios.from_mapping(short_plan({"plan.joint": True}))
    kept = improve.improved(scenario, sequence.phases, [None] * 4, None)
    assert kept.phases == tuple(sequence.phases)
    joint = kept.extra["joint"]
    assert not joint["kept"] and "7 passes" in joint["words"]
    if fault == "misses":
        assert "4 tasks would not be flown as asked" in joint["words"]
    else:
        assert "would not" not in joint["words"]
        assert joint["gain_J"] < -1e-3


LIMITED = {"plan.joint": True, "vehicle.wheels.speed_limit_rad_s": 50.0}
"""[rad/s] The second harvest of the sequence, which knows no limit, goes beyond it."""


def test_an_answer_of_all_tasks_that_breaks_a_limit_is_searched_again_within_it(
    sequence, monkeypatch
):
    assert np.abs(sequence.phases[2].series["omega_bw"]).max() > 60.0
    asked = []

    def solve(legs, *_, **__):
        asked.append([leg.manoeuvre.limits for leg in legs])
        given = torques(sequence)
        return JointAnswer(given, (None,) * 4, Status.CONVERGED, 0.0, 0.0, 7)

    monkeypatch.setattr(improve, "corrected", lambda manoeuvre, torque, dipole: torque)
    monkeypatch.setattr(improve, "solve_jointly", solve)
    monkeypatch.setattr(improve, "MOST_SEARCHES", 2)
    scenario = scenarios.from_mapping(short_plan(LIMITED))
    kept = improve.improved(scenario, sequence.phases, [None] * 4, None)
    assert not kept.extra["joint"]["kept"]
    first, second, third = asked
    assert first == [None] * 4
    # All have the limits, as they are; stricter are they only for the harvest that broke them.
    assert all(limits is not None and not limits.slower.any() for limits in second)
    assert third[2].slower.max() > 0.2
    assert not any(third[k].slower.any() for k in (0, 1, 3))


def test_across_a_task_the_wheels_are_held_to_their_speeds_where_it_ends(sequence):
    scenario = scenarios.from_mapping(short_plan(LIMITED))
    legs = [improve._leg(scenario, k, phase) for k, phase in enumerate(sequence.phases)]
    limits = keeping_to(legs[0].manoeuvre).limits
    plan = assembled(improve._within(legs, [limits] * 4), 4)
    program, p = joint_programme(plan.form), plan.parameters
    k = plan.intervals[1].start
    stage = jax.tree.map(lambda leaf: leaf[k], p.stages)
    rows = jax.jit(program.inequality)(plan.states[k], plan.controls[k], stage, p)
    ended = sequence.phases[1].series["omega_bw"][-1] / 50.0
    expected = np.concatenate([1.0 - ended, 1.0 + ended])
    np.testing.assert_allclose(rows[-6:], expected, atol=1e-6)


@pytest.mark.slow
def test_each_date_is_the_plan_of_that_date(sequence):
    scenario = scenarios.from_mapping(short_plan())
    own = scenario.orbit.days
    year = plan_year(scenario, np.array([own, own + 60.0]))
    assert year.reached
    # The same starts in another batch: the flights agree to what the solver leaves.
    assert year.total[0] == pytest.approx(energy_of(sequence.phases).net, abs=0.05)
    alone = planned({"orbit.epoch": "2023-05-13T09:35:11Z", **SIGHTLESS})
    np.testing.assert_allclose(year.total[1], energy_of(alone.phases).net, atol=0.05)
    base = sum(net_power(p).energy.baseline for p in alone.phases[::2])
    assert year.baseline[1] == pytest.approx(base, abs=0.05)


@pytest.mark.slow
def test_dates_that_fail_are_told_and_the_others_go_on_in_the_same_programme():
    scenario = scenarios.from_mapping(short_plan())
    days = scenario.orbit.days + np.array([-30.0, 10.0, 90.0])
    free = plan_year(scenario, days).plans
    assert free.reached.all()
    poor, rich = np.argmin(free.least_charge), np.argmax(free.least_charge)
    floor = free.least_charge[poor] + 1.0
    # What the programme counts is behind by half an interval, see above.
    assert free.least_charge[rich] > floor + 10.0
    held = scenarios.replace(scenario, {"limits.least_charge_percent": 100.0 * floor / CAPACITY})
    compiled = set(some_passes._begun)
    year = plan_year(held, days)
    assert set(some_passes._begun) == compiled
    assert not year.plans.reached[poor] and np.isnan(year.total[poor])
    assert year.plans.reason[poor].startswith('task 1 "first harvest": ')
    assert year.plans.reached[rich]
    assert year.plans.net[rich].sum() == pytest.approx(free.net[rich].sum(), abs=0.1)


TLE = [
    "1 51053U 22002BX  25250.94534449  .00021690  00000+0  44933-3 0  9999",
    "2 51053  97.3237 320.2120 0003081 229.8776 130.2204 15.45768954202998",
]
ELEMENTS = dict.fromkeys(key for key in DOCUMENT["orbit"] if key != "epoch")
NADIR = {
    "align": {"body": [0.0, 0.0, 1.0], "toward": "nadir"},
    "constrain": {"body": [1.0, 0.0, 0.0], "toward": "sun"},
}


def test_files_of_a_plan_are_one_motion(sequence, tmp_path):
    """Through all joints of tasks, where rates may jump: times rise, attitudes go on."""
    sequence.save(tmp_path / "plan")
    written = {
        form: export(tmp_path / "plan", tmp_path / form, form=form, orbit=True)
        for form in ("aem", "stk", "csv")
    }
    segments = read_aem(written["aem"][0].path)
    for before, after in itertools.pairwise(segments):
        assert before.moments[-1] == after.moments[0]
    assert all((np.diff(part.moments) > np.timedelta64(0)).all() for part in segments)
    rows = np.loadtxt(written["csv"][0].path, delimiter=",", skiprows=1, usecols=range(1, 9))
    assert (np.diff(rows[:, 0]) > 0.0).all() and rows[-1, 0] == 120.0
    turned = (
        Rotation.from_quat(rows[:-1, 1:5], scalar_first=True).inv()
        * Rotation.from_quat(rows[1:, 1:5], scalar_first=True)
    ).magnitude()
    fastest = np.linalg.norm(rows[:, 5:8], axis=1).max()
    assert (turned < 1.2 * fastest * np.diff(rows[:, 0])).all()
    tasks = options_of(sequence.scenario).tasks
    for task in (tasks[1], tasks[3]):
        k = int(np.argmin(np.abs(rows[:, 0] - task.start)))
        away = angle_between(rows[k, 1:5], task.pose.q_ib)
        assert rows[k, 0] == task.start and away < task.attitude_tolerance
        np.testing.assert_allclose(rows[k, 5:8], task.pose.omega_ib, atol=1e-8)
    count = written["stk"][0].path.read_text().split("NumberOfAttitudePoints")[1].split()[0]
    assert int(count) == len(rows)
    r, v = read_oem(written["csv"][1].path).over(sequence.scenario.orbit.days, 0.0, 120.0)(
        np.array([0.0, 77.0])
    )
    here = motion_of(sequence.scenario.orbit).at(jnp.asarray([0.0, 77.0]))
    np.testing.assert_allclose(r, here.position, atol=0.1)
    np.testing.assert_allclose(v, here.velocity, atol=1e-3)


@pytest.mark.slow
def test_an_orbit_of_elements_goes_on_to_the_dates():
    """Days before and after the epoch of a TLE, with the attitudes of those days."""
    changes = {f"orbit.{key}": None for key in ELEMENTS}
    for index in (1, 3):
        changes |= {f"tasks.{index}.{key}": None for key in ("attitude_quaternion", "target_deg")}
        changes |= {f"tasks.{index}.{key}": value for key, value in NADIR.items()}
    changes |= {"orbit.tle": TLE, "orbit.epoch": "2025-09-08T00:00:00Z"}
    changes |= {"tasks.1.rate_deg_s": None, "tasks.1.rate": "track"}
    scenario = scenarios.from_mapping(short_plan(changes))
    own = scenario.orbit.days
    days = np.array([own - 2.0, own, own + 3.0])
    year = plan_year(scenario, days, starts=2)
    assert year.reached, year.plans.reason
    satrec = Satrec.twoline2rv(*TLE)
    for day, orbit in zip(days, year.plans.orbits, strict=True):
        _, r, v = satrec.sgp4(2451545.0, day)
        here, speed = inertial_of_teme(np.array([day]), np.array([r]), np.array([v]))
        found = to_state(elements_of(orbit), orbit.gravitational_parameter)
        np.testing.assert_allclose(found[0], 1e3 * here[0], atol=0.1)
        np.testing.assert_allclose(found[1], 1e3 * speed[0], atol=1e-3)
    assert np.ptp(year.total) > 1.0
    words = " ".join(as_text(year.table(), 100).split())
    assert "By the age of its elements the orbit may be off by up to" in words
    lost = plan_year(scenario, np.array([own + 3000.0]), starts=2)
    assert not lost.reached and "take elements of about that date" in lost.plans.reason[0]
    assert np.isnan(lost.beta).all()
