"""A plan over the dates of a year: which dates, what is told of them, what is written."""

import csv
import json

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.drawing.rendering import as_text
from jaxatt.problems.net_power.dates import DatedPlan
from jaxatt.problems.reading.dates import moment_of
from jaxatt.scenarios import ScenarioError
from jaxatt.studies.plan_year import Year, plan_year
from jaxatt.studies.year_dates import beta_angle, read_dates

WHY = 'task 3 "harvest 2": the target rate is missed by 7 times its tolerance'


@pytest.fixture(scope="module")
def scenario():
    return scenarios.load("hypso2-orbit")


@pytest.fixture(scope="module")
def year(scenario):
    """Made by hand: 73 dates, of which the 11th cannot be flown."""
    days = read_dates("2022-01-01:2022-12-31:5", scenario)
    count, failed = len(days), 10
    wave = np.sin(2.0 * np.pi * np.arange(count) / count)
    harvested, baseline = 42000.0 + 3000.0 * wave, 38000.0 + 2500.0 * wave
    baseline[1] = -10.0
    for values in (harvested, baseline):
        values[failed] = np.nan
    reason = tuple(WHY if k == failed else "" for k in range(count))
    both = np.stack([harvested, 0.0 * harvested], axis=1)
    plans = DatedPlan(days, (scenario.orbit,) * count, both, both, np.full(count, 2.2e5), reason)
    beta = beta_angle([scenario.orbit] * len(days), days)
    return Year(scenario, plans, harvested, baseline, harvested - 9e3, beta, 302400.0, 4, 0)


def test_dates_are_at_the_hour_of_the_plan(scenario):
    days = read_dates("2022-01-01:2022-12-31", scenario)
    assert len(days) == 365
    assert f"{moment_of(days[0]):%Y-%m-%d %H:%M}" == "2022-01-01 09:31"
    assert f"{moment_of(days[-1]):%Y-%m-%d %H:%M}" == "2022-12-31 09:31"
    np.testing.assert_allclose(np.diff(days), 1.0)
    weekly = read_dates("2024-02-01:2024-03-01:7", scenario)
    assert [f"{moment_of(day):%m-%d}" for day in weekly] == [
        "02-01",
        "02-08",
        "02-15",
        "02-22",
        "02-29",
    ]
    assert len(read_dates("2022-05-01:2022-05-01", scenario)) == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("2022-01-01", "write the first and the last date"),
        ("2022-01-01:2022-02-30", "write the first and the last date"),
        ("2022-01-01:2022-02-01:a week", "write the first and the last date"),
        ("2022-01-01:2022-02-01:7:1", "write the first and the last date"),
        ("2022-02-01:2022-01-01", "the last date comes before the first; exchange them"),
        ("2022-01-01:2022-02-01:0", "0 days between dates; give more than zero"),
    ],
)
def test_dates_that_are_none_are_refused(scenario, text, words):
    with pytest.raises(ScenarioError) as error:
        read_dates(text, scenario)
    assert str(error.value).startswith(f"--dates {text}: ") and words in str(error.value)


def test_dates_need_an_orbit_with_an_epoch(scenario):
    days = read_dates("2022-01-01:2022-01-02", scenario)
    with pytest.raises(ScenarioError, match=r"\[orbit\] epoch: missing"):
        plan_year(scenarios.load("hypso1-netpower"), days)


def test_dates_outside_the_field_model_fail_with_the_reason(scenario):
    found = plan_year(scenario, np.array([-60000.0, 15000.0]))
    assert not found.reached and np.isnan(found.gain).all()
    assert ["epoch" in reason and "IGRF-14" in reason for reason in found.plans.reason] == [
        True,
        True,
    ]


def test_beta_angle_is_the_suns_height_above_the_orbit(scenario):
    """A retrograde orbit near the poles: over a year the sun goes to either side of it."""
    days = read_dates("2023-01-01:2023-12-31", scenario)
    beta = np.degrees(beta_angle([scenario.orbit] * len(days), days))
    inclination, node = np.radians(97.439), np.radians(139.3136)
    normal = [
        np.sin(inclination) * np.sin(node),
        -np.sin(inclination) * np.cos(node),
        np.cos(inclination),
    ]
    spring = np.argmin(np.abs(days - read_dates("2023-03-20:2023-03-20", scenario)))
    assert beta[spring] == pytest.approx(np.degrees(np.arcsin(normal[0])), abs=1.0)
    tilt = np.radians(23.44)
    summer = np.argmin(np.abs(days - read_dates("2023-06-21:2023-06-21", scenario)))
    height = np.cos(tilt) * normal[1] + np.sin(tilt) * normal[2]
    assert beta[summer] == pytest.approx(np.degrees(np.arcsin(height)), abs=1.0)


def test_no_date_fails_silently(year):
    assert not year.reached
    text = as_text(year.table(), 80)
    assert "…" not in text and max(map(len, text.splitlines())) <= 80
    words = " ".join(text.split())
    assert "1 of 73 dates cannot be flown:" in words
    assert f"2022-02-20: {WHY}" in words
    assert "Some of the dates; year.csv has all." in words
    gain = year.gain[np.isfinite(year.gain)]
    assert f"{gain.min():.1f} to {gain.max():.1f} J, mean {gain.mean():.1f} J" in words
    assert repr(year) == "Year(hypso2-orbit: 72 of 73 dates flown)"


def test_files_of_a_year_can_be_read_again(year, tmp_path):
    files = year.save(tmp_path)
    assert [file.name for file in files] == ["year.csv", "year.json", "year.png", "beta.png"]
    assert all(file.stat().st_size > 2000 for file in files)
    with (tmp_path / "year.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    stored = json.loads((tmp_path / "year.json").read_text())
    assert (stored["scenario"], stored["starts"], stored["reached"]) == ("hypso2-orbit", 4, False)
    assert len(rows) == len(stored["dates"]) == 73
    for row, entry in zip(rows, stored["dates"], strict=True):
        assert row["date"] == entry["date"] and row["reason"] == entry["reason"]
        assert (row["gain_J"] == "") == (entry["gain_J"] is None) == (not entry["reached"])
    assert float(rows[0]["gain_J"]) == pytest.approx(year.gain[0])
    assert float(rows[0]["least_charge_percent"]) == pytest.approx(100.0 * 2.2e5 / 302400.0)
    assert stored["dates"][10]["reason"] == WHY and rows[10]["least_charge_percent"] == ""
    # Of a law that loses, a percentage says nothing.
    assert rows[1]["gain_percent"] == "" and rows[1]["gain_J"] != ""


def test_the_figures_mark_the_dates_that_fail(year):
    column = year.plot().axes
    assert [axes.get_ylabel() for axes in column] == [
        "harvests [kJ]",
        "gain [J]",
        "least charge [%]",
        "beta angle [deg]",
    ]
    np.testing.assert_allclose(column[1].lines[0].get_ydata(), year.gain)
    assert len(column[1].lines) == 2 and len(column[0].lines) == 3
    energies, gains, _ = year.plot_beta().axes
    assert gains.get_ylabel() == "gain [J]" and energies.get_xlabel() == "beta angle [deg]"
    np.testing.assert_allclose(
        gains.collections[0].get_offsets(), np.stack([np.degrees(year.beta), year.gain], axis=1)
    )
