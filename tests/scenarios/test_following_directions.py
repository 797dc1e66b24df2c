"""Feedback flights whose reference follows directions, beside astropy and a rest among stars."""

import jax.numpy as jnp
import numpy as np
import pytest
from references import short_flights
from references.astropy_sight import astropy_sight
from scipy.spatial.transform import Rotation

from jaxatt import scenarios
from jaxatt.problems.along_orbit import along_orbit
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import ScenarioError
from jaxatt.scenarios.flight_build import build_flight
from jaxatt.simulation.campaign import fly_runs

X, Z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
SITE = {"toward": "site", "latitude_deg": 63.42, "longitude_deg": 10.39}
TRACK = {
    "align": {"body": Z, **SITE},
    "constrain": {"body": X, "toward": "velocity"},
    "rate": "track",
}
LAWS = {
    "pd": None,
    "tracking": {"kind": "tracking", "proportional_1_s2": 0.5, "derivative_1_s": 1.2},
}
DURATION = 100.0


def flight(reference, duration=DURATION, **initial):
    """Over Trondheim, which the satellite passes 70 s after the start."""
    return short_flights.flight(
        orbit={
            **dict.fromkeys(short_flights.ELEMENTS),
            "tle": scenarios.load("hypso1-ground-site").document["orbit"]["tle"],
        },
        environment={"epoch": "2025-09-08T20:41:40Z"},
        initial={
            "attitude_deg": None,
            "rate_rad_s": None,
            "wheel_speed_rad_s": [0.0, 0.0, 0.0, 0.0],
            "align": TRACK["align"],
            "constrain": TRACK["constrain"],
            "rate": "track",
            **initial,
        },
        reference={"attitude_deg": None, **reference},
        simulation={"duration_s": duration, "sampling_s": 0.1, "records": 20},
        laws=LAWS,
    )


def flown(case):
    """Times (n,), attitudes q_ib of n records as rotations, and rates (n, 3) in inertial axes."""
    shared, start = build_flight(case)
    recorded = fly_runs(shared, start, case.laws["tracking"], 1, 0).recorded
    count = recorded.q_ob.shape[1]
    times = case.timing.duration / count * np.arange(1, count + 1)
    here = along_orbit(motion_of(case.surroundings.orbit), times)
    q_io, q_ob = (Rotation.from_quat(q, scalar_first=True) for q in (here.q_io, recorded.q_ob[0]))
    return times, q_io * q_ob, q_io.apply(q_ob.apply(recorded.omega_ob[0]) + here.omega_io)


def test_a_place_is_followed_through_the_whole_pass():
    pytest.importorskip("astropy")
    case = flight(TRACK)
    times, turns, _ = flown(case)
    motion = motion_of(case.surroundings.orbit)
    place = (*np.deg2rad([63.42, 10.39]), 0.0)
    swept = []
    for time, turn in zip(times, turns, strict=True):
        here = motion.at(jnp.asarray(time))
        sight = astropy_sight(case.surroundings.orbit.days, time, here.position, place)
        off = np.linalg.norm(np.cross(turn.apply(Z), sight))
        assert np.rad2deg(off) < 0.02
        across = np.cross(sight, np.array(here.velocity))
        assert abs(turn.apply(X) @ across) < 5e-4 * np.linalg.norm(across)
        swept.append(sight)
    assert np.rad2deg(np.arccos(swept[0] @ swept[-1])) > 60.0


@pytest.mark.parametrize("direction", ["sun", "nadir", "satellite", "field"])
def test_directions_are_followed_for_long(direction):
    aim = {"body": Z, "toward": direction}
    if direction == "satellite":
        aim["satellite"] = {**short_flights.ELEMENTS, "raan_deg": 319.0}
    star = {"body": X, "direction_inertial": [0.3, -0.2, 1.0]}
    case = flight({"align": aim, "constrain": star, "rate": "track"}, align=aim, constrain=star)
    path = case.asked.path
    times, turns, rates = flown(case)
    wanted, asked = path.at(times)
    wanted = Rotation.from_quat(wanted, scalar_first=True)
    assert np.rad2deg((wanted.inv() * turns).magnitude()).max() < 0.02
    np.testing.assert_allclose(wanted.inv().apply(rates), asked, atol=1e-5)
    turned = np.rad2deg((wanted[0].inv() * wanted[-1]).magnitude())
    assert turned < 0.01 if direction == "sun" else turned > 3.0


def test_rest_among_the_stars_lasts():
    begins = {"align": {"body": Z, "toward": "nadir"}, "rate": "inertial"}
    case = flight({**TRACK, **begins}, 1000.0, **begins)
    _, turns, rates = flown(case)
    assert np.rad2deg((turns[0].inv() * turns).magnitude().max()) < 0.01
    np.testing.assert_allclose(rates, 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("reference", "duration", "words"),
    [
        (TRACK, 600.0, ["is out of sight", "horizon at 2025-09-08T20:4", "align"]),
        ({**TRACK, "from_s": 100.0}, 100.0, ["from_s", "leaves nothing of a flight of 100 s"]),
        ({"rate": "track"}, 100.0, ["rate", "given without an attitude", "add align"]),
        ({"rate": "inertial"}, 100.0, ["rate", "given without an attitude", "add align"]),
        ({**TRACK, "rate_rad_s": [0.0, 0.0, 0.0]}, 100.0, ["rate", "keep one of the two"]),
        ({"attitude_deg": [0.0, 0.0, 0.0], "rate": "track"}, 100.0, ["nothing to track"]),
    ],
)
def test_what_cannot_be_followed_is_refused(reference, duration, words):
    with pytest.raises(ScenarioError) as caught:
        flight(reference, duration)
    for each in words:
        assert each in str(caught.value)
