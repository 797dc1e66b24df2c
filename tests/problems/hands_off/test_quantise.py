"""Valves that are open or shut fly where the relaxed answer flew, on a small slew."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.candidates import Candidates
from jaxatt.problems.hands_off.search.quantise import Quantised, quantise
from jaxatt.problems.hands_off.search.search import search
from jaxatt.problems.hands_off.slew.task import SlewTask

SMALL = {
    "horizon.intervals": 15,
    "horizon.coast_intervals": 1,
    "target.attitude_quaternion": None,
    "target.attitude_deg": [150.0, 20.0, -30.0],
}


def small_task(changes: dict | None = None) -> SlewTask:
    task = build_slew(scenarios.replace(scenarios.load("eseo-1"), {**SMALL, **(changes or {})}))
    assert isinstance(task, SlewTask)
    return task


@pytest.fixture(scope="module")
def relaxed() -> Candidates:
    return search(small_task(), 8, 0).best


def within(task: SlewTask, found: Quantised) -> bool:
    return all(found.errors[name] <= task.tolerances[name] for name in found.errors)


def test_relaxed_answer_respects_one_sided_limits(relaxed: Candidates) -> None:
    assert relaxed.verdict.reached[0]
    assert (relaxed.controls >= 0.0).all() and (relaxed.controls <= 0.195 + 1e-15).all()


@pytest.mark.parametrize("shortest", [0.0, 0.05, 0.2, 0.6])
def test_pulse_widths_reach_with_the_shortest_opening(relaxed: Candidates, shortest: float) -> None:
    task = small_task({"vehicle.thrusters.minimum_on_time_s": shortest})
    found = quantise(task, relaxed.controls[0], float(relaxed.sign[0]), "pulse-width")
    assert found.reached == within(task, found)
    width = found.pulses.on_time
    assert (width[width > 0.0] >= shortest - 1e-12).all()
    assert (width <= task.step + 1e-12).all()
    assert found.partly_open == 0 and found.opposed == 0
    assert found.active.sum() <= (relaxed.controls[0] > 0.0).any(axis=1).sum()
    if shortest < 0.5:
        assert found.reached, "the widths that are left make up for those that were dropped"


def test_minimum_impulse_acts_as_a_shortest_opening(relaxed: Candidates) -> None:
    task = small_task({"vehicle.thrusters.minimum_impulse_Nms": 0.195 * 0.1})
    found = quantise(task, relaxed.controls[0], float(relaxed.sign[0]), "pulse-width")
    width = found.pulses.on_time
    assert found.reached and (width[width > 0.0] >= 0.1 - 1e-12).all()


def test_whole_intervals_are_whole_and_better_than_rounding(relaxed: Candidates) -> None:
    task, controls, sign = small_task(), relaxed.controls[0], float(relaxed.sign[0])
    found = quantise(task, controls, sign, "interval")
    width = found.pulses.on_time
    assert np.isin(np.round(width / task.step, 12), (0.0, 1.0)).all()
    assert found.partly_open == 0 and found.opposed == 0
    rounded = quantise(task, controls, sign, "interval", aims=False)

    def miss(one: Quantised) -> float:
        return max(one.errors[name] / task.tolerances[name] for name in one.errors)

    assert miss(found) <= miss(rounded)


def test_opposed_thrusters_are_netted(relaxed: Candidates) -> None:
    task = small_task()
    common = 0.3 * (0.195 - relaxed.controls[0].max(axis=1, keepdims=True))
    both = relaxed.controls[0] + common * (relaxed.controls[0].max(axis=1, keepdims=True) > 0.0)
    found = quantise(task, both, float(relaxed.sign[0]), "pulse-width")
    assert found.opposed == 0 and found.reached
