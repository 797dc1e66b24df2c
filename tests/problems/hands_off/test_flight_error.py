"""Verdicts on slews and openings of valves beside flights under error control (SciPy's DOP853)."""

import dataclasses

import jax
import numpy as np
import pytest
from references import adapters, random_vehicles, wheeled_body

from jaxatt import scenarios
from jaxatt.environment.table import tabulate
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.quantise import judge_pulses
from jaxatt.problems.hands_off.slew.flight import fly_slew
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Goal, Weights
from jaxatt.problems.manoeuvre import Grid, InitialState, Target
from jaxatt.simulation.flight import fly_torque
from jaxatt.simulation.pulses import Pulses

INTERVALS, OLD_STEPS = 4, 20
TOLERANCE = {"attitude": np.radians(0.01), "rate": 1e-5}
GOAL = Goal("l0", "reach", 1, 1e-6, Weights(1.0, 1.0, 1.0, 0.0))


def draw(rng):
    """Random vehicle with momentum, long intervals and random torques (N, n) [N m]."""
    body, space = random_vehicles.body(rng, 3), random_vehicles.space(rng)
    step = float(rng.choice([2.0, 8.0, 30.0]))
    nutation = 10.0 ** rng.uniform(-1.5, 0.8) / step**0.5
    speeds = np.linalg.solve(body.axes, body.inertia @ (nutation * random_vehicles.unit(rng, 3)))
    state = InitialState(
        random_vehicles.unit(rng, 4), 0.2 / step * rng.normal(size=3), speeds / body.spin
    )
    torque = 1e-3 * rng.uniform(-1.0, 1.0, (INTERVALS, 3))
    return body, space, state, step, torque


def slew(body, space, state, step, target):
    return SlewTask(
        adapters.craft(body),
        adapters.surroundings(space),
        state,
        target,
        Grid(INTERVALS, step, 0, 0.0, substeps=1),
        GOAL,
        np.ones(INTERVALS),
        np.zeros(INTERVALS, bool),
        axes="wheels",
    )


def check(seed):
    """Judge a flight whose target is where 20 steps an interval say that it ends.

    Returns whether the answer counts as reached, whether it does reach, and whether it does with
    room to spare and its flights agree.
    """
    body, space, state, step, torque = draw(np.random.default_rng(seed))
    somewhere = Target(state.q_ob, np.zeros(3), *TOLERANCE.values())
    first = slew(body, space, state, step, somewhere)
    table = tabulate(adapters.surroundings(space), 0.0, step, INTERVALS, OLD_STEPS)
    old = jax.jit(fly_torque)(first.craft, first.start, torque, table)
    target = dataclasses.replace(
        somewhere, q_ob=np.asarray(old.q_ob[-1]), omega_ob=np.asarray(old.omega_ob[-1])
    )
    task = slew(body, space, state, step, target)
    flown = fly_slew(task, torque[None])
    exact = wheeled_body.fly(body, space, state.q_ob, state.omega_ob, state.omega_bw, torque, step)
    right = {
        "attitude": wheeled_body.angle_between(exact.q[-1], target.q_ob),
        "rate": np.linalg.norm(exact.relative[-1] - target.omega_ob),
    }
    error = flown.flight_error
    if error.agreed:
        for name, bound in error.named.items():
            assert abs(flown.verdict.errors[name][0] - right[name]) < bound + 1e-8
    claimed = bool(flown.verdict.reached[0]) and error.agreed
    within = [all(right[name] <= share * TOLERANCE[name] for name in right) for share in (1.1, 0.9)]
    return claimed, within[0], within[1] and error.agreed


def no_false_claim(seeds):
    found = np.array([check(seed) for seed in seeds])
    claimed, reaches, clearly = found.T
    assert not (claimed & ~reaches).any()
    assert claimed[clearly].all()
    assert claimed.any() and not claimed.all()


def test_no_answer_of_a_random_vehicle_counts_as_reached_that_does_not_reach():
    no_false_claim(range(5))


@pytest.mark.slow
def test_none_of_twenty_counts_as_reached_that_does_not_reach():
    no_false_claim(range(100, 120))


def test_openings_of_valves_are_flown_until_two_flights_agree():
    task = build_slew(
        scenarios.replace(
            scenarios.load("eseo-1"),
            {
                "horizon.intervals": 4,
                "horizon.coast_intervals": 0,
                "horizon.horizon_s": 400.0,
                "initial.rate_rad_s": [0.05, 0.03, -0.04],
            },
        )
    )
    rng = np.random.default_rng(5)
    count = task.craft.thrusters.count
    opens = rng.uniform(0.0, 50.0, (4, count)) * (rng.random((4, count)) < 0.3)
    pulses = Pulses(
        opens, opens + 0.02 * (opens > 0.0), np.zeros((4, task.craft.wheels.count)), task.step
    )
    found = judge_pulses(task, pulses, "pulse-width")
    error = found.flight_error
    assert error.agreed and error.steps > 40
    finer = task.fly_pulses(pulses, times=16)
    np.testing.assert_allclose(found.flown.omega_ob, finer.omega_ob, atol=error.rate)
    same = np.abs(np.sum(np.asarray(found.flown.q_ob) * finer.q_ob, axis=-1))
    assert (2.0 * np.arccos(np.minimum(1.0, same)) < error.attitude + 1e-7).all()


def test_flights_in_pieces_are_one_flight():
    for changes in ({}, {"horizon.coast_intervals": 3}):
        base = {"horizon.intervals": 6, "windows": None, **changes}
        task = build_slew(scenarios.replace(scenarios.load("hypso1-90-45-15-perturbed"), base))
        controls = 1e-5 * np.random.default_rng(2).normal(size=(1, 6, task.size))
        once, twice = task.fly(controls), task.fly(controls, times=3)
        for name in ("q_ob", "omega_ob", "omega_bw", "wheel_torque"):
            a, b = np.asarray(getattr(once, name)), np.asarray(getattr(twice, name))
            assert a.shape == b.shape
            np.testing.assert_allclose(a, b, rtol=1e-5, atol=1e-6)
