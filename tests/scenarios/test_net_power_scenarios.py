"""Manoeuvres and plans that earn energy: the bundled cases, what is read, what is refused."""

import copy
import math
import tomllib

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.net_power.build import options_of
from jaxatt.scenarios import ScenarioError

TURN = tomllib.loads(scenarios.text("hypso1-netpower"))
PLAN = tomllib.loads(scenarios.text("hypso2-orbit"))
PANEL = {"normals": [[1.0, 0.0, 0.0]], "area_m2": [0.1], "efficiency": 0.2}
MAGNETIC = {
    "name": "coils",
    "title": "A turn by magnetorquers alone",
    "source": "test",
    "vehicle": {"use": "hypso1-magnetic"},
    "orbit": PLAN["orbit"],
    "initial": {"attitude_quaternion": [1.0, 0.0, 0.0, 0.0], "frame": "orbit"},
    "target": {"attitude_quaternion": [0.0, 1.0, 0.0, 0.0], "frame": "orbit"},
    "horizon": {"final_time": "free", "longest_s": 6000.0, "intervals": 60},
    "objective": {"kind": "net-power", "cost": "mean-power", "time_weight_W_s": 1e-4},
}


def edited(document, changes):
    """A document with "table.key" replaced; None drops one."""
    document = copy.deepcopy(document)
    for path, value in changes.items():
        *parents, key = path.split(".")
        place = document
        for part in parents:
            place = place[int(part)] if isinstance(place, list) else place.setdefault(part, {})
        place.pop(key, None)
        if value is not None:
            place[key] = value
    return document


def refusal(document):
    with pytest.raises(ScenarioError) as caught:
        scenarios.from_mapping(document, origin="mine.toml")
    message = str(caught.value)
    assert message.startswith("mine.toml: ")
    assert "; " in message, "no mend in the message"
    return message


def test_chapter_4_holds_the_printed_values():
    case = scenarios.load("hypso1-netpower")
    options = options_of(case)
    assert (case.family, case.objective.kind, case.objective.terminal) == (
        "net-power",
        "net-power",
        "reach",
    )
    assert case.orbit is None and case.notes == ()
    assert (case.horizon.duration, case.horizon.intervals, case.horizon.step) == (40.0, 80, 0.5)
    light = options.satellite.light
    assert (light.irradiance, light.shadow, options.satellite.wheel_power) == (
        1361.0,
        None,
        "signed",
    )
    sun = light.sun / np.linalg.norm(light.sun)
    np.testing.assert_allclose(sun, [0.2673, 0.5345, 0.8018], atol=1e-4)
    np.testing.assert_array_equal(case.initial.q_ob, [0.0, 0.0, 1.0, 0.0])
    np.testing.assert_array_equal(case.targets[0].q_ob, [0.0, 1.0, 0.0, 0.0])
    assert math.degrees(case.targets[0].attitude_tolerance) == pytest.approx(0.01)
    law = options.baseline
    assert law is not None
    assert (law.proportional, law.derivative, law.hold, law.turn_back) == (8e-2, 0.108, 0.5, 20.0)
    assert (options.load, options.floor, options.tasks) == (0.0, -math.inf, ())
    assert (case.solver.starts, case.solver.seed) == (64, 0)
    assert case.printed["rows"] == [{"label": "manoeuvre", "net_J": 566.4, "baseline_J": 501.2}]


def test_chapter_5_holds_the_printed_values():
    case = scenarios.load("hypso2-orbit")
    options = options_of(case)
    assert len(options.tasks) == 20 and options.joint
    assert (case.horizon.duration, case.horizon.intervals) == (6576.0, 3288)
    momentum = options.satellite.momentum
    assert momentum is not None and momentum.gain == 5.0
    np.testing.assert_array_equal(momentum.wheel_speed, [209.4, 209.4, 209.4, -362.8])
    assert options.satellite.wheel_power == "body" and options.satellite.gravity_gradient
    law = options.baseline
    assert law is not None
    assert (law.proportional, law.derivative, law.hold) == (1e-2, 3.56e-2, None)
    # What three digits of a quaternion leave of its length is said.
    assert len(case.notes) == 10 and all("normalised" in note for note in case.notes)
    rows = case.printed["rows"]
    assert [row["label"] for row in rows] == [t.name for t in options.tasks if t.searched]
    assert sum(row["net_J"] - row["baseline_J"] for row in rows) == pytest.approx(3229.0, abs=0.5)


def test_magnetorquers_alone_in_free_time():
    case = scenarios.from_mapping(MAGNETIC)
    options = options_of(case)
    assert case.horizon.free and case.horizon.longest == 6000.0
    assert options.satellite.decided_dipole and options.satellite.momentum is None
    assert (options.cost, options.weights.time) == ("mean-power", 1e-4)
    assert (options.initial_frame, options.target_frame) == ("orbit", "orbit")
    field = options.satellite.orbit.field
    assert field is not None and options.satellite.light.shadow is not None


def test_the_end_may_be_free_and_the_wheels_have_a_wish():
    free = edited(TURN, {"target": None})
    assert scenarios.from_mapping(free).targets == ()
    case = scenarios.from_mapping(
        edited(TURN, {"target.wheel_speed_rad_s": [10.0, 0.0, -10.0], "target.frame": "inertial"})
    )
    np.testing.assert_array_equal(options_of(case).wheel_speed_at_end, [10.0, 0.0, -10.0])


def test_the_printed_cost_has_weights_and_the_floor_a_charge():
    changes = {
        "objective.terminal": "penalty",
        "objective.attitude_weight_J": 3.75e4,
        "objective.rate_weight_J_s2": 3.75e6,
        "vehicle.battery": {"capacity_Wh": 10.0, "charge_percent": 50.0},
        "limits.least_charge_percent": 20.0,
        "vehicle.loads": {"harvest_W": 13.5},
    }
    options = options_of(scenarios.from_mapping(edited(TURN, changes)))
    assert (options.weights.attitude, options.weights.rate) == (3.75e4, 3.75e6)
    assert options.floor == pytest.approx(0.2 * 36e3)
    assert options.load == 13.5


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        # the vehicle: what earns, and what is not counted
        (
            {"vehicle.use": "hypso1", "initial.wheel_speed_rad_s": None},
            ["[vehicle.panels]: missing", "add it with normals"],
        ),
        (
            {"vehicle.panels": {"area_m2": [0.03, 0.06, 0.0, 0.03, 0.06, 0.02]}},
            ["panel 3 has 0 m^2", "leave out faces"],
        ),
        (
            {"vehicle.panels": {"normals": [[0.0, 0.0, 0.0]] * 6}},
            ["[vehicle.panels] normals", "give the direction"],
        ),
        (
            {"vehicle.battery": {"capacity_Wh": 10.0, "charge_Wh": 11.0}},
            ["charge_Wh = 11.0: starts above the capacity"],
        ),
        (
            {"vehicle.battery": {"capacity_Wh": 10.0, "charge_percent": 120.0}},
            ["charge_percent = 120.0: starts above the capacity"],
        ),
        (
            {"vehicle.use": "eseo", "vehicle.panels": PANEL, "initial.wheel_speed_rad_s": None},
            ["[vehicle.thrusters]: their propellant is not counted in watts", "drop them"],
        ),
        # tables that do not fit together
        ({"tasks": PLAN["tasks"]}, ["[target]: not beside [[tasks]]", "drop one of the two"]),
        ({"plan": {"joint": False}}, ["[plan]: there are no [[tasks]]", "drop it"]),
        ({"horizon": None}, ["[horizon] is missing", "horizon_s and intervals"]),
        ({"initial": None}, ["[initial]"]),
        ({"windows": []}, ["windows"]),
        # the horizon
        ({"horizon.coast_intervals": 3}, ["coast_intervals = 3: nothing follows", "drop it"]),
        ({"horizon.horizon_s": 1e7}, ["at most 1e+06"]),
        ({"printed.rows": 3}, ["[printed] rows: must be a list of tables"]),
        ({"printed.rows": [{"net_J": 1.0}]}, ["[[printed.rows]] no. 1 label: missing"]),
        ({"printed.rows": [{"label": "x", "net_J": "1"}]}, ["net_J", '"1" is not a number']),
        ({"printed.totals_J": [1.0]}, ["[printed] baseline_totals_J: missing"]),
        ({"horizon.horizon_s": -1.0}, ["[horizon] horizon_s = -1.0: must be greater than 0"]),
        ({"horizon.shortest_s": 10.0}, ["the final time is fixed", 'final_time = "free"']),
        (
            {"horizon.final_time": "free"},
            ["[horizon] longest_s: missing", "longest_s = 6000.0"],
        ),
        (
            {"horizon": {"final_time": "free", "longest_s": 99.0, "intervals": 8}},
            ['final_time = "free": only for satellites with magnetorquers alone', '"fixed"'],
        ),
        # the objective
        ({"objective.cost": "mean-power"}, ['cost = "mean-power": in fixed time', '"energy"']),
        ({"objective.cost": "power"}, ["not one of the choices", "allowed: energy, mean-power"]),
        ({"objective.wheel_power": "wheel"}, ["did you mean 'wheels'"]),
        ({"objective.time_weight_W_s": 1.0}, ["the final time is fixed", "drop it"]),
        (
            {"objective.attitude_weight_W": 1.0},
            ['cost = "energy" is in J', "give attitude_weight_J"],
        ),
        (
            {"objective.rate_weight_J_s2": 1.0},
            ['terminal = "reach" has no weights', 'use "penalty"'],
        ),
        ({"objective.terminal": "penalty"}, ["attitude_weight_J: missing"]),
        # the law to compare with
        ({"baseline.attitude_gain_Nm": 0.0}, ["[baseline] attitude_gain_Nm = 0.0"]),
        ({"baseline.rate_gain_Nm_s": None}, ["rate_gain_Nm_s: missing", "0.108"]),
        ({"baseline.turn_back_s": -1.0}, ["turn_back_s = -1.0: must be at least 0"]),
        ({"baseline.nearest_to": "sun"}, ["allowed: start, end"]),
        ({"baseline.gain": 1.0}, ["unknown key"]),
        # light, disturbances and coils without an orbit
        ({"light.sun_inertial": None}, ["sun_inertial: missing, and there is no date"]),
        ({"light.sun_inertial": [0.0, 0.0, 0.0]}, ["is no direction"]),
        ({"light.shadow": "conical"}, ["there is no [orbit]", 'shadow = "none"']),
        ({"light.penumbra": 0.2}, ["there is no shadow", "drop it"]),
        ({"disturbances.gravity_gradient": True}, ["gravity_gradient", "there is no [orbit]"]),
        ({"magnetorquing.mode": "decided"}, ["no magnetorquers", "[vehicle.magnetorquers]"]),
        # start and end
        ({"initial.frame": "orbit"}, ["there is no [orbit]", '"inertial"']),
        ({"target.frame": "orbit"}, ["there is no [orbit]", '"inertial"']),
        ({"target.attitude_quaternion": None}, ["rate_rad_s", "without an attitude"]),
        (
            {"vehicle.wheels": {"speed_limit_rad_s": 5.0}, "initial.wheel_speed_rad_s": [9, 0, 0]},
            ["[initial] wheel_speed_rad_s", "exceeds the speed limit", "choose slower wheels"],
        ),
        # the battery's floor
        ({"limits.least_charge_percent": 20.0}, ["the vehicle has no battery"]),
        (
            {
                "vehicle.battery": {"capacity_Wh": 10.0, "charge_percent": 15.0},
                "limits.least_charge_percent": 20.0,
            },
            ["the battery starts below it", "lower the floor"],
        ),
    ],
)
def test_a_manoeuvre_is_refused(changes, parts):
    message = refusal(edited(TURN, changes))
    assert all(part in message for part in parts), message


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"orbit.epoch": "2031-01-01T00:00:00Z"}, ["is outside 1900-01-01 to 2030-01-01"]),
        ({"orbit.epoch": "1890-01-01T00:00:00Z"}, ["[orbit] epoch", "give a date within"]),
        ({"horizon.horizon_s": 6577.0}, ["1 s before it", "harvest"]),
        ({"horizon.intervals": 9}, ["the tasks have their own lengths", "give step_s"]),
        ({"plan.least_elevation_deg": 89.0}, ["at least 89 deg are asked for"]),
        ({"plan.jointly": True}, ["[plan] jointly", "unknown key"]),
        ({"magnetorquing.gain": 0.0}, ["[magnetorquing] gain = 0.0"]),
        ({"magnetorquing.mode": "sometimes"}, ["none, manage-momentum, decided"]),
        ({"tasks.1.start": "09:32:31"}, ['no. 2 "Svalbard" start', "overlaps", "20 s"]),
        ({"tasks.3.target_deg": [0.0, 0.0]}, ['no. 4 "Finnmark"', "out of sight"]),
        (
            {"limits.least_charge_percent": 79.9, "vehicle.loads": {"communicate_W": 400.0}},
            ['no. 2 "Svalbard"', "the battery cannot stay above its floor", "too little"],
        ),
        ({"tasks": []}, ["tasks: must be a list of tables"]),
    ],
)
def test_a_plan_is_refused(changes, parts):
    message = refusal(edited(PLAN, changes))
    assert all(part in message for part in parts), message


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"orbit.epoch": None}, ["[light] sun_inertial: missing", "add the direction"]),
        (
            {"orbit.epoch": None, "light.sun_inertial": [1.0, 0.0, 0.0]},
            [
                "[orbit] epoch: missing",
                "needs the magnetic field of IGRF-14, which depends on the date",
            ],
        ),
        ({"orbit": None, "light.sun_inertial": [1.0, 0.0, 0.0]}, ["there is no [orbit]"]),
        ({"magnetorquing.mode": "manage-momentum"}, ["the vehicle has no wheels", '"decided"']),
        ({"objective.wheel_power": "body"}, ["the vehicle has no wheels", "drop it"]),
        ({"baseline": TURN["baseline"]}, ["[baseline]", "it needs wheels", "drop"]),
        ({"horizon.shortest_s": 7000.0}, ["more than longest_s = 6000", "exchange"]),
        (
            {"objective.terminal": "penalty", "objective.attitude_weight_J": 1.0},
            ['cost = "mean-power" is in W', "give attitude_weight_W"],
        ),
    ],
)
def test_magnetorquers_alone_are_refused(changes, parts):
    message = refusal(edited(MAGNETIC, changes))
    assert all(part in message for part in parts), message
