"""Vehicles whose inertia, actuators, limits, disturbances and momenta are all multiplied alike."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.search.candidates import better
from jaxatt.problems.hands_off.slew.mounting import mounting
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.verdict import Verdict

TURN = {
    "vehicle": {"use": "hypso1"},
    "target.axis": [1, 0, 0],
    "target.angle_deg": 90.0,
    "initial.wheel_speed_rad_s": [0, 0, 200.0, 0],
    "horizon.intervals": 20,
}
SLEW = "hypso1-90-45-15-perturbed"
CASES = {
    "l0": (SLEW, {}, 8),
    "moving-l0": (SLEW, {"objective.kind": "moving-l0"}, 8),
    "l1": (SLEW, {"objective.kind": "l1"}, 8),
    "printed cost": (SLEW, {"objective.terminal": "penalty"}, 8),
    "thrusters": ("eseo-3", {}, 4),
    "time and effort": ("mrp-k3-rk4", {**TURN, "objective": {"kind": "time-effort"}}, 6),
    "least time": ("mrp-k3-rk4", {**TURN, "objective": {"kind": "minimum-time"}}, 6),
    "net power": ("hypso1-netpower", {"horizon.intervals": 20}, 4),
}
"""Slews are disturbed, and wheels store momentum where time counts."""
LONG = ("printed cost", "net power")
SLOW = (*LONG, "moving-l0", "l1", "thrusters", "time and effort")
GIVEN = {
    "disturbances.sinusoidal_torque_Nm": 1,
    "objective.epsilon_Nm": 1,
    "objective.effort_weight": -2,
    "objective.on_off_weight": -2,
    "baseline.attitude_gain_Nm": 1,
    "baseline.rate_gain_Nm_s": 1,
}
"""Keys beside the vehicle's, and the power of the factor that multiplies each where it is given."""


def case(name):
    scenario, changes, starts = CASES[name]
    return scenarios.replace(scenarios.load(scenario), {**changes, "solver.starts": starts})


def multiplied(scenario, factor):
    """The scenario with a vehicle `factor` times as heavy and strong, in the same time."""
    craft, document = scenario.vehicle, scenario.document
    changes = {"vehicle.inertia_kgm2": factor * craft.inertia}
    if craft.wheels.count:
        changes["vehicle.wheels.inertia_kgm2"] = factor * craft.wheels.inertia
        changes["vehicle.wheels.torque_limit_Nm"] = factor * craft.wheels.torque_limit
    if craft.thrusters.count:
        changes["vehicle.thrusters.torque_limit_Nm"] = factor * craft.thrusters.torque_limit
    if craft.panels is not None:
        changes["vehicle.panels.area_m2"] = factor * craft.panels.area
    for path, power in GIVEN.items():
        table, key = path.split(".")
        if key in document.get(table, {}):
            changes[path] = factor**power * document[table][key]
    return scenarios.replace(scenario, changes)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow, pytest.mark.optimised] * (name in SLOW))
        for name in CASES
    ],
)
def test_the_same_motion_with_torques_in_proportion_and_nothing_compiled_again(name, compilations):
    """From 1e-6 to 1e6 times a vehicle, whatever the objective."""
    base = case(name)
    want = solve(base).phases[0]
    assert want.reached, want.failure_reason
    if name == "least time":
        # 0.042 N m s must leave the z wheel and enter the y wheel, at 0.006 N m: a bound.
        assert want.final_time == pytest.approx(14.0, rel=1e-4)
        assert build_time_task(base).form.body.substeps > 4
    compilations.clear()
    rng = np.random.default_rng([16, list(CASES).index(name)])
    for factor in 10.0 ** (np.array([-1.0, 1.0]) * rng.uniform(1.0, 6.0, 2)):
        phase = solve(multiplied(base, factor)).phases[0]
        assert phase.reached, f"times {factor:.3g}: {phase.failure_reason}"
        np.testing.assert_array_equal(phase.active, want.active)
        assert phase.final_time == pytest.approx(want.final_time, rel=1e-9)
        torque = factor * want.controls
        if name != "least time":  # which leaves open what the wheel does that is not short of time
            assert phase.l1_effort == pytest.approx(factor * want.l1_effort, rel=1e-6)
            np.testing.assert_allclose(phase.controls, torque, rtol=0, atol=1e-4 * torque.max())
        assert phase.starts.distinct_minima == want.starts.distinct_minima
        if name == "net power":
            assert phase.section.energy.net == pytest.approx(
                factor * want.section.energy.net, rel=1e-9
            )
    # In a worker that has run many other tests, small functions of the host are forgotten.
    large = ("some_passes", "_begin", "_fly")
    assert not [made for made in compilations if name not in LONG or any(x in made for x in large)]


def test_published_cases_keep_the_threshold_of_the_source():
    """Schaanning (2021), definition 5.1.1: 1e-6 N m."""
    slews = [name for name in scenarios.names() if name.startswith(("hypso1-9", "hypso1-path"))]
    assert len(slews) >= 6
    for name in slews:
        scenario = scenarios.load(name)
        scale = mounting(scenario.vehicle, scenario.control.axes).scale
        np.testing.assert_allclose(SlewTask.threshold * scale, 1e-6, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_defaults_in_units_of_torque_follow_the_vehicle(seed):
    factor = 10.0 ** np.random.default_rng([17, seed]).uniform(-6.0, 6.0)
    slew = scenarios.replace(scenarios.load("hypso1-90-45-15"), {"objective": {"kind": "l1"}})
    assert slew.objective.epsilon == pytest.approx(1e-8)
    assert slew.objective.sparsity_weight == pytest.approx(10.0)
    larger = multiplied(slew, factor).objective
    assert larger.epsilon == pytest.approx(1e-8 * factor)
    assert larger.sparsity_weight == pytest.approx(10.0 / factor)
    counted = scenarios.replace(multiplied(slew, factor), {"objective.kind": "l0"})
    assert counted.objective.sparsity_weight == 10.0
    turn = scenarios.replace(scenarios.load("mrp-k3"), {"objective": {"kind": "time-effort"}})
    assert turn.objective.effort_weight == pytest.approx(0.01)
    weight = multiplied(turn, factor).objective.effort_weight
    assert weight == pytest.approx(0.01 / factor**2)


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_whether_wheels_hold_momentum_is_a_matter_of_the_vehicle(factor):
    base = scenarios.replace(case("least time"), {"horizon.substeps": 1})
    for speed, momentum in ((1e-12, "zero"), (1e-6, "carried")):
        turning = {"initial.wheel_speed_rad_s": [0.0, speed, 0.0, 0.0]}
        task = build_time_task(multiplied(scenarios.replace(base, turning), factor))
        assert task.form.body.momentum == momentum
        assert task.in_motion == (momentum == "carried")


def test_an_excess_is_judged_by_the_limit_and_an_effort_by_itself():
    weak = Verdict({}, {}, np.array([1e-9, 1e-21]), np.zeros(2), 3e-9)
    np.testing.assert_array_equal(weak.arrives, [False, True])
    np.testing.assert_array_equal(weak.pick(np.array([1, 0])).reached, [True, False])
    for factor in 10.0 ** np.arange(-6.0, 7.0, 3.0):
        less, same = 0.0059 * factor, 0.006 * factor * (1.0 + 1e-7)
        rank = np.array([2.0, 2.0, 0.006 * factor])
        assert better(np.array([2.0, 2.0, less]), rank)
        assert not better(np.array([2.0, 2.0, same]), rank)
        assert not better(rank, np.array([2.0, 2.0, same]))
