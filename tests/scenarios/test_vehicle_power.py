"""Panels, battery, loads and light of a scenario: what is read, and every refusal."""

import copy

import numpy as np
import pytest

from jaxatt.environment.eclipse import Shadow
from jaxatt.problems.reading.light import read_light
from jaxatt.problems.reading.orbit import read_orbit
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.scenarios import ScenarioError, load_vehicle, vehicle_names

VEHICLE = {
    "inertia_kgm2": [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
    "wheels": {
        "axes": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "inertia_kgm2": 1e-4,
        "torque_limit_Nm": 1e-3,
        "efficiency": 0.8,
        "regeneration": 0.25,
    },
    "magnetorquers": {"dipole_limit_Am2": 0.3, "full_power_W": 2.0},
    "panels": {
        "normals": [[2, 0, 0], [0, 1, 0]],
        "area_m2": [0.1, 0.2],
        "efficiency": [0.2, 0.3],
        "shades": 2,
    },
    "battery": {"capacity_Wh": 50, "charge_percent": 60, "input_efficiency": 0.9},
    "loads": {"harvest_W": 10, "communicate_W": 40.0},
}
ORBIT = {
    "semi_major_axis_km": 6898.0,
    "eccentricity": 0.0007,
    "inclination_deg": 97.4,
    "raan_deg": 215.4,
    "argument_of_periapsis_deg": 83.6,
    "true_anomaly_deg": 34.0,
    "epoch": "2022-04-01T00:00:00Z",
}


def read(data=VEHICLE, **options):
    return read_vehicle(data, "sat.toml", None, [], **options)


def edited(path, value):
    """Return the vehicle with one value set, or removed where it is None."""
    data = copy.deepcopy(VEHICLE)
    part, _, key = path.partition(".")
    place, key = (data[part], key) if key else (data, part)
    if value is None:
        del place[key]
    else:
        place[key] = value
    return data


def test_everything_is_read():
    craft = read()
    assert craft.panels is not None and craft.battery is not None
    np.testing.assert_array_equal(craft.panels.normals, [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    np.testing.assert_array_equal(craft.panels.shades, [0.0, 1.0])
    assert craft.panels.incidence_exponent == 1
    assert (craft.battery.capacity, craft.battery.charge) == (180e3, 108e3)
    assert (craft.battery.input_efficiency, craft.battery.output_efficiency) == (0.9, 1.0)
    assert craft.loads == {"harvest": 10.0, "communicate": 40.0}
    assert (craft.wheels.efficiency, craft.wheels.regeneration) == (0.8, 0.25)
    assert craft.magnetorquers is not None and craft.magnetorquers.full_power == 2.0
    assert read(edited("battery.charge_percent", None)).battery.charge == 180e3


def test_vehicles_without_power_are_as_before():
    craft = load_vehicle("hypso1")
    assert craft.panels is None and craft.battery is None and craft.loads == {}
    assert (craft.wheels.efficiency, craft.wheels.regeneration) == (1.0, 0.0)


@pytest.mark.parametrize("name", vehicle_names())
def test_bundled_vehicles_are_complete(name):
    craft = load_vehicle(name)
    assert craft.name == name
    alone = craft.wheels.count == 0 and craft.thrusters.count == 0
    assert alone == (name == "hypso1-magnetic")
    assert (craft.panels is not None) == (name in ("hypso1-solar", "hypso2", "hypso1-magnetic"))


def test_bundled_vehicle_with_an_override():
    craft = read({"use": "hypso2", "battery": {"charge_percent": 50}})
    assert craft.battery.charge == 0.5 * craft.battery.capacity
    assert craft.battery.input_efficiency == 0.92
    assert craft.wheels.count == 4


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("panels.area_m2", None, r"\[vehicle.panels\] area_m2: missing; add a line"),
        ("panels.area_m2", [0.1, 0.0], r"area_m2 = .*panel 2 has 0 m\^2; .*leave out faces"),
        ("panels.area_m2", [0.1], r"area_m2 = .*2 panels; give 2"),
        ("panels.normals", [[1, 0, 0], [0, 0, 0]], r"normals = .*panel 2 .*; give the direction"),
        ("panels.normals", [[1, 0], [0, 1]], r"normals = .*; give one row of three numbers"),
        ("panels.efficiency", 20, r"efficiency = 20: .*; give the share"),
        ("panels.shades", 3, r"shades = 3: is panel 3; there are 2"),
        ("panels.shades", 0, r"shades = 0: must be at least 1"),
        ("panels.incidence", "cosin", r"incidence = .*did you mean 'cosine'"),
        ("panels.area", [0.1, 0.2], r"unknown key; did you mean 'area_m2'\?"),
        ("battery.charge_percent", 101, r"charge_percent = 101: starts above the capacity.*; give"),
        ("battery.capacity_J", 5.0, r"capacity_J = 5.0: given beside capacity_Wh; keep one"),
        ("battery.charge_Wh", 5.0, r"charge_Wh = 5.0: given beside charge_percent; keep one"),
        ("battery.capacity_Wh", None, r"charge_percent = 60: of an unknown capacity; add"),
        ("battery.input_efficiency", 92, r"input_efficiency = 92: .*; give a share"),
        ("battery.capacity", 50, r"unknown key; did you mean 'capacity_Wh'"),
        ("loads.harvest_W", -1.0, r"harvest_W = -1.0: must be at least 0"),
        ("loads.imaging_W", 1.0, r"\[vehicle.loads\] imaging_W = 1.0: unknown key; did you mean"),
        ("wheels.efficiency", 85, r"efficiency = 85: .*; give one number"),
        ("magnetorquers.full_power_W", -2.0, r"full_power_W = -2.0: .*; give one number"),
        ("magnetorquers.turns", 100, r"full_power_W = 2.0: .*; keep one"),
    ],
)
def test_bad_vehicles_are_refused(path, value, words):
    with pytest.raises(ScenarioError, match=words):
        read(edited(path, value))


def test_charge_above_the_capacity_in_watt_hours():
    data = edited("battery.charge_percent", None)
    data["battery"]["charge_Wh"] = 51.0
    with pytest.raises(ScenarioError, match=r"charge_Wh = 51.0: starts above .*, 50 Wh; give less"):
        read(data)


def test_magnetorquers_alone_fly_only_where_that_is_allowed():
    alone = edited("wheels", None)
    assert read(alone, magnetorquers_alone=True).wheels.count == 0
    with pytest.raises(ScenarioError, match=r"wheels: missing, and magnetorquers alone .*; add"):
        read(alone)
    del alone["magnetorquers"]
    with pytest.raises(ScenarioError, match=r"wheels: missing; add a line"):
        read(alone, magnetorquers_alone=True)


def test_light_by_default_and_in_full():
    orbit = read_orbit(ORBIT, "sat.toml", None, [])
    light = read_light({}, "sat.toml", orbit)
    assert light.sun is None and light.irradiance == 1361.0
    assert light.shadow is not None and light.shadow.penumbra == 0.2
    given = {
        "irradiance_W_m2": 1366.0,
        "sun_inertial": [0.8944, 0.0, 0.4472],
        "sun_distance_m": 1.4959987e11,
        "penumbra": "disk",
        "earth_radius_m": 6.4e6,
    }
    light = read_light(given, "sat.toml", orbit)
    assert np.linalg.norm(light.sun) == pytest.approx(1.4959987e11)
    assert light.shadow is not None and light.shadow.penumbra is None
    assert light.shadow.earth_radius == 6.4e6
    assert light.shadow.sun_radius == Shadow().sun_radius
    free = read_light({"sun_inertial": [0.2673, 0.5345, 0.8018]}, "sat.toml", None)
    assert free.shadow is None


@pytest.mark.parametrize(
    ("data", "orbit", "words"),
    [
        ({}, False, r"\[light\] sun_inertial: missing, and there is no date .*; add"),
        ({"sun_inertial": [0, 0, 0]}, True, r"sun_inertial = .*: is no direction; give"),
        ({"sun_inertial": [1, 0, 0], "shadow": "conical"}, False, r"there is no \[orbit\]; add"),
        ({"shadow": "none", "penumbra": 0.1}, True, r"penumbra = 0.1: there is no shadow; drop"),
        ({"penumbra": 1.5}, True, r"penumbra = 1.5: must be at most 1"),
        ({"penumbra": "disc"}, True, r'penumbra = "disc": .*"disk"'),
        ({"shadow": "cylindrical"}, True, r"shadow = .*allowed: none, conical"),
        ({"sun_distance_m": 1.5e11}, True, r"sun_distance_m = .*: the date gives it; drop"),
        ({"sun_inertial": [1, 0, 0], "sun_distance_m": 1.0}, True, r"must be greater than 1e\+09"),
        ({"irradiance": 1361.0}, True, r"unknown key; did you mean 'irradiance_W_m2'"),
    ],
)
def test_bad_light_is_refused(data, orbit, words):
    around = read_orbit(ORBIT, "sat.toml", None, []) if orbit else None
    with pytest.raises(ScenarioError, match=words):
        read_light(data, "sat.toml", around)
