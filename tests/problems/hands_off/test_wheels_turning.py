"""Slews that begin with wheels that turn."""

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew


def case(speed, **changes):
    wheels = {"initial.wheel_speed_rad_s": [0.0, 0.0, speed, 0.0]}
    return scenarios.replace(scenarios.load("hypso1-90-45-15"), {**wheels, **changes})


def test_steps_of_the_search_follow_from_what_turns():
    steps = [build_slew(case(speed)).substeps for speed in (0.0, 1.0, 100.0, 400.0)]
    assert steps[:2] == [1, 1] and steps[2] > 2 and steps[3] > 2 * steps[2]
    coarse = {"horizon.horizon_s": 350.0}
    assert build_slew(case(100.0, **coarse)).substeps > 3 * steps[2]
    assert build_slew(case(100.0, **{"horizon.substeps": 2})).substeps == 2
    spinning = {"initial.rate_rad_s": [0.3, 0.2, 0.1]}
    assert build_slew(case(0.0, **spinning)).substeps > 1
