"""Dates are asked of what needs them: sun, magnetic field, nothing else."""

import pytest
from references import short_flights

from jaxatt import scenarios
from jaxatt.environment import epoch
from jaxatt.scenarios import ScenarioError

SUN = "hypso1-90-45-15-keep-out"
SUNLIT = {"area_m2": 0.1, "reflectance": 0.5, "lever_m": [0.0, 0.0, 0.1]}
DRAG = {"density_kg_m3": 1e-13, "area_m2": 0.1, "coefficient": 2.2, "lever_m": [0.0, 0.0, 0.1]}
DIPOLE = {"residual_dipole_Am2": [0.01, 0.0, 0.0]}


def dated(date, **changes):
    return scenarios.replace(scenarios.load(SUN), {"orbit.epoch": date, **changes})


def flown(date, **environment):
    document = dict(short_flights.flight().document)
    document["environment"] = {**environment, **({} if date is None else {"epoch": date})}
    return scenarios.flight_from_mapping(document)


@pytest.mark.parametrize("date", ["1850-01-01", "1935-01-01", "2031-06-01", "2051-01-01"])
def test_what_needs_no_model_has_any_date(date):
    assert dated(date, **{"keep_out.0.toward": "nadir"}).orbit.days is not None
    assert flown(date, gravity_gradient=True, drag=DRAG).surroundings.days is not None
    assert flown(date, solar_pressure=SUNLIT, sun_direction=[1.0, 0.0, 0.0]).surroundings.days


@pytest.mark.parametrize(
    ("make", "inside", "outside"),
    [
        (dated, "1950-01-01", "1949-12-31T23:59:59"),
        (dated, "2049-12-31T23:00:00", "2050-01-01T00:00:01"),
        (dated, "2049-12-31T23:00:00", "2049-12-31T23:59:59"),
        (lambda date: flown(date, solar_pressure=SUNLIT), "2035-01-01", "1935-01-01"),
        (lambda date: flown(date, **DIPOLE), "1900-01-01", "1899-12-31T23:59:59"),
        (lambda date: flown(date, **DIPOLE), "2029-12-31", "2030-01-01T00:00:01Z"),
        (lambda date: flown(date, eddy_coefficient=1.0), "1935-01-01", "2030-01-01T00:00:01Z"),
    ],
)
def test_what_needs_a_model_has_its_dates(make, inside, outside):
    make(inside)
    with pytest.raises(ScenarioError, match=r"(epoch = |ends at ).* is outside .*, which is known"):
        make(outside)


def test_the_end_of_a_motion_counts_too():
    with pytest.raises(ScenarioError, match=r"the motion ends at 2050-01-01T00:01:37Z, which is"):
        dated("2049-12-31T23:59:59Z")


def test_sunlight_needs_a_date():
    with pytest.raises(ScenarioError, match="epoch: missing, and solar_pressure without sun_dir"):
        flown(None, solar_pressure=SUNLIT)
    flown(None, solar_pressure=SUNLIT, sun_direction=[1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    "text", ["2016-12-31T23:59:60Z", "2016-12-31T23:59:60", "2017-01-01T01:59:60+02:00"]
)
def test_a_leap_second_is_the_first_of_the_next_day(text):
    assert epoch.parse(text) == epoch.parse("2017-01-01T00:00:00Z")
    assert dated(text).orbit.days == dated("2017-01-01").orbit.days


def test_a_second_60_at_another_time_is_named():
    with pytest.raises(ScenarioError, match="has a second 60; only the last second of a day"):
        dated("2016-12-31T22:59:60Z")


@pytest.mark.parametrize(
    "text", ["soon", "2016-12-31T23:60:00", "0001-01-01T00:00+14:00", "9999-12-31T23:59-10:00"]
)
def test_what_is_no_moment_is_named(text):
    with pytest.raises(ScenarioError, match="is no moment; write it as"):
        dated(text)
