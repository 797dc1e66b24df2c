"""Every refusal names the place, the value and the mend."""

import copy
import math
import tomllib

import pytest

from jaxatt import scenarios
from jaxatt.scenarios import ScenarioError

SPACECRAFT = tomllib.loads(scenarios.text("hypso1-90-45-15"))
PATH = tomllib.loads(scenarios.text("hypso1-path"))
TOY = tomllib.loads(scenarios.text("double-integrator"))
INLINE = {
    "name": "box",
    "inertia_kgm2": [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
    "wheels": {
        "axes": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "inertia_kgm2": 1e-4,
        "torque_limit_Nm": [1e-3, 1e-3, 2e-3],
    },
}
INLINE_TEXT = """inertia_kgm2 = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
[wheels]
axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
inertia_kgm2 = 1e-4
torque_limit_Nm = 1e-3
"""
GONE = object()


def edit(document, path, value):
    """Return a copy with one value set, or removed."""
    document = copy.deepcopy(document)
    place = document
    *parents, key = path.split(".")
    for part in parents:
        place = place[int(part)] if isinstance(place, list) else place.setdefault(part, {})
    if value is GONE:
        del place[key]
    else:
        place[key] = value
    return document


def refusal(document):
    with pytest.raises(ScenarioError) as caught:
        scenarios.from_mapping(document, origin="scenario.toml")
    message = str(caught.value)
    assert message.startswith("scenario.toml: ")
    assert "; " in message, "no mend in the message"
    return message


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        # unknown keys, misspelt names, forgotten units
        (
            "horizon.horizon",
            70,
            ["[horizon] horizon = 70: unknown key", "'horizon_s'", "units are"],
        ),
        ("horizon.horizon_ms", 70, ["'horizon_s'"]),
        ("vehicle.wheels", {"torque_limit": 1.0}, ["[vehicle.wheels]", "'torque_limit_Nm'"]),
        ("vehicle.torque_limit_Nm", 1.0, ["put it into [vehicle.wheels]"]),
        ("target.attitude", [0, 0, 0], ["'attitude_deg'", "units are"]),
        ("target.atitude_deg", [0, 0, 0], ["'attitude_deg'"]),
        ("orbit.semi_major_axis", 6852.2, ["'semi_major_axis_km'"]),
        ("orbit.semi_major_axis_m", 6852200, ["'semi_major_axis_km'"]),
        ("horizon.starts", 8, ["put it into [solver]"]),
        ("horizon_s", 8, ["put it into [horizon]"]),
        ("objectve", {}, ["unknown table", "'objective'"]),
        ("solver.zzz", 8, ["allowed here: starts, seed"]),
        ("windows.0.wieght", 0.1, ["[[windows]] no. 1", "'weight'"]),
        # units that do not fit
        ("orbit.semi_major_axis_km", 6852200.0, ["kilometres, not metres"]),
        ("orbit.semi_major_axis_km", 500.0, ["below the Earth's surface", "not the altitude"]),
        ("orbit.eccentricity", 0.2, ["below the Earth's surface"]),
        ("orbit.gravitational_parameter_m3_s2", 398600.4, ["not km^3/s^2"]),
        # types
        ("horizon.horizon_s", "70 s", ['"70 s" is not a number', "in seconds"]),
        ("horizon.horizon_s", True, ["true is not a number"]),
        ("horizon.intervals", 50.0, ["whole number"]),
        ("horizon.intervals", True, ["whole number"]),
        ("horizon.intervals", 2**40, ["at most 100000"]),
        ("target.attitude_deg", 90.0, ["must be a list"]),
        ("target.attitude_deg", [90.0, 45.0], ["has 2 entries", "give 3 numbers"]),
        ("target.attitude_deg", [90.0, "45", 0.0], ['"45" is not a number']),
        ("initial.wheel_speed_rad_s", [0.0, 0.0, 0.0], ["give 4 numbers"]),
        ("disturbances.gravity_gradient", 1, ["true or false"]),
        ("target", 3, ["[target]", "not a table"]),
        ("windows", {"weight": 1}, ["double brackets"]),
        ("legs", [{"attitude_deg": [0, 0, 0]}], ["[target] and [[legs]]"]),
        ("printed", 3, ["[printed]"]),
        ("printed.l0", 3, ["[printed.l0]: 3 is not a table"]),
        ("printed.l0.active_intervals", "two", ["[printed.l0] active_intervals", "not a number"]),
        ("printed.l0.relative_sparsity_percent", 101, ["at most 100"]),
        ("name", "", ["must be a text"]),
        ("name", "../up", ["folder of the output, results/NAME"]),
        ("name", "a/b", ["letters, digits"]),
        ("name", "x" * 101, ["at most 100"]),
        # not finite
        ("horizon.horizon_s", math.inf, ["horizon_s = inf", "finite"]),
        ("horizon.horizon_s", 10**400, ["finite"]),
        ("horizon.horizon_s", 1e300, ["beyond 1e+09, 30 years", "seconds"]),
        ("horizon.horizon_s", 1e-300, ["at least 1e-30"]),
        ("initial.rate_rad_s", [0.0, 1e31, 0.0], ["beyond 1e+30"]),
        ("horizon.substeps", 10**5, ["at most 10000"]),
        ("solver.starts", 10**7, ["at most 1000000"]),
        (
            "disturbances",
            {"sinusoidal_torque_Nm": 1e-6, "sinusoidal_frequency_rad_s": 1e6},
            ["1.4e+06 rad in a control interval of 1.4 s", "more intervals"],
        ),
        ("target.attitude_deg", [math.nan, 0, 0], ["finite", "degrees"]),
        ("solver.starts", math.nan, ["whole number"]),
        # ranges
        ("horizon.horizon_s", -70.0, ["= -70.0", "greater than 0"]),
        ("horizon.intervals", 0, ["at least 1"]),
        ("horizon.coast_intervals", -1, ["at least 0"]),
        ("horizon.substeps", 0, ["at least 1"]),
        ("orbit.eccentricity", -0.1, ["at least 0"]),
        ("orbit.eccentricity", 1.0, ["must be less than 1"]),
        ("orbit.inclination_deg", 200.0, ["at most 180", "degrees"]),
        ("target.attitude_tolerance_deg", 0.0, ["greater than 0"]),
        ("target.attitude_tolerance_deg", 200.0, ["at most 180"]),
        ("target.rate_tolerance_rad_s", -1e-5, ["greater than 0"]),
        ("disturbances.sinusoidal_frequency_rad_s", -1.0, ["at least 0"]),
        ("objective.epsilon_Nm", 0.0, ["greater than 0"]),
        ("objective.sparsity_weight", -1.0, ["at least 0"]),
        ("objective.design", 4, ["allowed: 1, 2, 3"]),
        ("objective.kind", "moving", ["did you mean 'moving-l0'", "allowed: l0, moving-l0, l1"]),
        ("objective.terminal", "reached", ["did you mean 'reach'"]),
        ("control.axes", 3, ["allowed: body, wheels"]),
        ("system", "spacecrft", ["did you mean 'spacecraft'"]),
        ("solver.starts", 0, ["at least 1"]),
        ("solver.seed", -1, ["at least 0"]),
        # attitudes
        ("target.attitude_quaternion", [1, 0, 0, 0], ["beside attitude_deg", "keep one"]),
        ("initial", {"attitude_quaternion": [0, 0, 0, 0]}, ["is zero", "unit quaternion"]),
        ("initial", {}, ["attitude_deg: missing"]),
        # windows
        ("windows.0.last_interval", 50, ["outside the horizon of 50 intervals", "0 to 49"]),
        ("windows.0.first_interval", -1, ["at least 0"]),
        ("windows.0.first_interval", 31, ["before first_interval = 31"]),
        ("windows.0.weight", -0.1, ["at least 0"]),
        ("windows.0.forbidden", True, ["drop weight or forbidden"]),
        ("windows.0.start_s", 28.0, ["beside interval numbers"]),
        ("windows", [{"start_s": 28.0, "end_s": 71.0}], ["outside the horizon of 70 s"]),
        ("windows", [{"start_s": 42.0, "end_s": 28.0}], ["before start_s"]),
        ("windows", [{"start_s": 42.0}], ["end_s: missing"]),
        (
            "windows",
            [{"first_interval": 0, "last_interval": 49, "forbidden": True}],
            ["all 50 intervals"],
        ),
        # missing
        ("vehicle", GONE, ["[vehicle] is missing", "scenarios show"]),
        ("orbit", GONE, ["[orbit] is missing"]),
        ("orbit.raan_deg", GONE, ["raan_deg: missing", "raan_deg = 0.0"]),
        ("target", GONE, ["[target] is missing"]),
        ("horizon.intervals", GONE, ["intervals: missing"]),
        # vehicles
        ("vehicle.use", "hypso-1", ["no bundled vehicle", "did you mean 'hypso1'"]),
        ("vehicle.file", "other.toml", ["beside use"]),
        ("vehicle", {}, ["inertia_kgm2: missing", "give use or file"]),
        ("initial.state", [0, 0], ["unknown key"]),
    ],
)
def test_spacecraft_scenarios_that_are_refused(path, value, parts):
    message = refusal(edit(SPACECRAFT, path, value))
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        ("inertia_kgm2", [[0.1, 0.0], [0.0, 0.1]], ["[vehicle] inertia_kgm2", "three rows"]),
        ("inertia_kgm2", 0.1, ["inertia_kgm2 = 0.1", "three rows"]),
        ("inertia_kgm2", [[0.1, 0.1, 0], [0, 0.1, 0], [0, 0, 0.1]], ["not symmetric"]),
        ("inertia_kgm2", [[0.1, 0, 0], [0, -0.1, 0], [0, 0, 0.1]], ["positive definite"]),
        ("inertia_kgm2", [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.3]], ["triangle inequality"]),
        ("inertia_kgm2", [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]], ["wheels' own inertia"]),
        ("inertia_kgm2", [[math.nan, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], ["nan", "finite"]),
        ("inertia_kgm2", [[1e308, 0, 0], [0, 1e308, 0], [0, 0, 1e308]], ["beyond 1e+30"]),
        ("wheels.axes", [[10**400, 0, 0], [0, 1, 0], [0, 0, 1]], ["axes", "inf"]),
        ("wheels.inertia_kgm2", 1e-31, ["at least 1e-30"]),
        ("inertia_kgm2", [["0.1", 0, 0], [0, 0.1, 0], [0, 0, 0.1]], ["real numbers"]),
        ("wheels", GONE, ["wheels: missing"]),
        ("wheels", 3, ["[vehicle.wheels]", "not a table"]),
        ("wheels.axes", GONE, ["axes: missing"]),
        ("wheels.axes", [[1, 0, 0], [0, 1, 0]], ["[vehicle.wheels] axes", "(0, 0, 1)"]),
        ("wheels.axes", [[1, 0], [0, 1], [1, 1]], ["one row of three numbers"]),
        ("wheels.axes", [], ["(3, 0)"]),
        ("wheels.axes", [[1, 0, 0], [0, 1, 0], [0, 0, 0]], ["wheel 3", "(0, 0, 0)"]),
        ("wheels.axes", [[1, 0, 0], [0, 1, 0], [0, 0, "1"]], ["plain numbers"]),
        ("wheels.axes", [[1, 0, 0], [0, 1, 0], [0, 0, math.inf]], ["inf", "finite"]),
        ("wheels.inertia_kgm2", -1e-4, ["inertia_kgm2 = -0.0001", "greater than 0"]),
        ("wheels.torque_limit_Nm", [1e-3, 1e-3], ["there are 3 wheels", "one number for all"]),
        ("wheels.torque_limit_Nm", [1e-3, 1e-3, -1e-3], ["torque_limit_Nm", "greater than 0"]),
        ("wheels.torque_limit_Nm", "3 mNm", ["torque_limit_Nm", "without quotes"]),
        ("wheels.torque_limit_Nm", math.inf, ["finite"]),
        ("wheels.speed_limit_rad_s", 0, ["speed_limit_rad_s", "greater than 0"]),
        ("name", 3, ["[vehicle] name = 3", "text"]),
    ],
)
def test_vehicles_that_are_refused(path, value, parts):
    document = edit(SPACECRAFT, "vehicle", edit(INLINE, path, value))
    document["initial"].pop("wheel_speed_rad_s")
    message = refusal(document)
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        ("waypoint.time_s", 70.0, ["outside the horizon", "between 0 and 70"]),
        ("waypoint.time_s", -1.0, ["outside the horizon"]),
        ("waypoint.time_s", 0.2, ["start of the horizon"]),
        ("waypoint.time_s", 69.9, ["end of the horizon"]),
        ("waypoint.tolerance_deg", 0.0, ["greater than 0"]),
        ("waypoint.time", 35.0, ["'time_s'"]),
        ("waypoint.attitude_deg", GONE, ["attitude_deg: missing"]),
    ],
)
def test_waypoints_that_are_refused(path, value, parts):
    message = refusal(edit(PATH, path, value))
    for part in parts:
        assert part in message


def test_a_waypoint_and_legs_exclude_each_other():
    document = {key: value for key, value in PATH.items() if key != "target"}
    document["legs"] = [PATH["target"]]
    assert "[waypoint] and [[legs]]" in refusal(document)


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        ("orbit", {}, ["no meaning for system = double-integrator"]),
        ("initial.state", [1.0], ["has 1 entries", "give 2 numbers"]),
        ("target.attitude_deg", [0, 0, 0], ["unknown key"]),
        ("target", GONE, ["state: missing"]),
        ("target.tolerance", 0.0, ["greater than 0"]),
        ("control.limit", -1.0, ["greater than 0"]),
        ("objective.terminal", "penalty", ["no printed penalty", '"reach"']),
        ("objective.epsilon", -1.0, ["greater than 0"]),
    ],
)
def test_toy_scenarios_that_are_refused(path, value, parts):
    message = refusal(edit(TOY, path, value))
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"name = ", "not valid TOML"),
        (b"[horizon]\nhorizon_s = 70 s\n", "line 2"),
        (b"name = 1\nname = 2\n", "may appear once"),
        (b"\xff\xfe\x00", "UTF-8"),
    ],
)
def test_files_that_are_no_toml(tmp_path, content, part):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(ScenarioError, match=part) as caught:
        scenarios.load(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize(
    ("encoding", "mark"),
    [
        ("utf-8", b""),
        ("utf-8", b"\xef\xbb\xbf"),
        ("utf-16-le", b"\xff\xfe"),
        ("utf-16-be", b"\xfe\xff"),
    ],
)
def test_files_as_windows_writes_them(tmp_path, encoding, mark, newline):
    vehicle = f'name = "höhe"\n{INLINE_TEXT}'
    for name, text, load in (
        ("scenario", scenarios.text("hypso1-90-45-15"), scenarios.load),
        ("flight", scenarios.text("hypso1-pointing"), scenarios.load_flight),
        ("vehicle", vehicle, None),
    ):
        path = tmp_path / f"{name}.toml"
        path.write_bytes(mark + text.replace("\n", newline).encode(encoding))
        if load is not None:
            assert load(path).document == tomllib.loads(text)
    document = edit(SPACECRAFT, "vehicle", {"file": str(tmp_path / "vehicle.toml")})
    document["initial"].pop("wheel_speed_rad_s")
    assert scenarios.from_mapping(document).vehicle.name == "höhe"


def test_utf_16_without_a_mark_is_named(tmp_path):
    path = tmp_path / "bare.toml"
    path.write_bytes(scenarios.text("hypso1-90-45-15").encode("utf-16-le"))
    with pytest.raises(ScenarioError, match=r"UTF-16 without a byte order mark .* as UTF-8"):
        scenarios.load(path)


@pytest.mark.parametrize("name", ["missing.toml", "."])
def test_files_that_cannot_be_read(tmp_path, name):
    with pytest.raises(ScenarioError, match="cannot be read"):
        scenarios.load_file(tmp_path / name)
