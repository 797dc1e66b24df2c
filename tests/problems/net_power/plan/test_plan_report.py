"""How a plan is shown: its table in a narrow terminal, its course, its timeline and its map."""

import re

import numpy as np
import pytest
from handmade_plan import LAW, SHADED, handmade_plan
from handmade_results import changed
from short_plan import short_plan

from jaxatt import scenarios
from jaxatt.drawing.rendering import as_text
from jaxatt.drawing.world_map import WORLD, part_around
from jaxatt.problems.net_power.record import energy_of, net_power
from jaxatt.problems.net_power.report.plan_course import course_of
from jaxatt.problems.net_power.report.plan_figures import figures, overview
from jaxatt.problems.net_power.report.plan_table import totals
from jaxatt.report.tables import result_table


@pytest.fixture(scope="module")
def plan():
    return handmade_plan()


def numbers(energy, gained=True):
    """The cells of one row."""
    cells = [f"{energy.net:.1f}", f"{energy.baseline:.1f}"]
    return [*cells, f"{energy.gain:+.1f}"] if gained else cells


@pytest.mark.parametrize("width", [80, 100])
def test_every_number_of_the_table_can_be_read(plan, width):
    text = as_text(result_table(plan), width)
    lines = text.splitlines()
    assert "…" not in text
    assert max(map(len, lines)) <= width
    rows = [" ".join(line.split()) for line in lines]
    for phase in plan.phases:
        found = net_power(phase)
        cells = " ".join(numbers(found.energy, found.mode == "harvest"))
        row = rf"{found.task.split()[0]}.* {found.mode} \d\d:\d\d:\d\d {phase.final_time:g} "
        assert any(re.match(row + re.escape(cells), line) for line in rows), found.task
    for _, energy in totals(plan.phases):
        assert any(" ".join(numbers(energy)) in line for line in rows)


def test_a_task_that_is_not_flown_is_named_with_the_reason(plan):
    text = " ".join(as_text(result_table(plan), 80).split())
    assert "(not flown)" in text
    assert 'Task 7 "harvest 4" is not flown as asked: the target rate is missed by 2e-3' in text


def test_percentages_of_a_law_that_loses_are_left_out():
    plan = handmade_plan()
    first = plan.phases[0]
    losing = net_power(first).energy.__class__(10.0, 1.0, 0.0, -5.0)
    lost = plan.__class__(**(vars(plan) | {"phases": (changed(first, energy=losing),)}))
    row = next(x for x in as_text(result_table(lost), 80).splitlines() if "+14.0" in x)
    assert row.split()[-4:] == ["9.0", "-5.0", "+14.0", "-"]


def test_the_course_adds_up_over_the_tasks(plan):
    course = course_of(plan)
    whole = energy_of(plan.phases)
    harvested = sum(task.duration for task in course.tasks if task.searched)
    assert (np.diff(course.time) >= 0.0).all()
    # Powers are constant but for the step in which the light goes, or comes back.
    assert course.energy[-1] == pytest.approx(whole.net, abs=0.1)
    assert course.baseline[-1] - course.energy[-1] == pytest.approx(LAW * harvested)
    dark = course.time[course.light < 0.5]
    assert dark.min() >= SHADED[0] and dark.max() <= SHADED[1]


def test_the_timeline_has_what_an_operator_asks_for(plan):
    figure = overview(plan)
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert labels == [
        "",
        "power [W]",
        "net energy [kJ]",
        "charge [%]",
        "rate [deg/s]",
        "wheel speeds [rpm]",
    ]
    names = {text.get_text() for text in figure.axes[0].texts}
    assert names == {task.name for task in course_of(plan).tasks if not task.searched}
    ours, law, *_ = figure.axes[2].lines
    np.testing.assert_allclose(ours.get_ydata()[-1], 1e-3 * course_of(plan).energy[-1])
    np.testing.assert_allclose(law.get_ydata()[-1], 1e-3 * course_of(plan).baseline[-1])
    assert figure.axes[-1].get_xlabel() == "time [UTC]"
    # The shadow is shaded in every panel.
    for axes in figure.axes[1:]:
        spans = [
            patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches
        ]
        assert any(
            abs(span.x0 - SHADED[0]) < 4.0 and abs(span.x1 - SHADED[1]) < 4.0 for span in spans
        )


def test_the_map_shows_every_place_once_and_as_much_of_the_world_as_is_needed(plan):
    (world,) = (figure().axes[0] for figure in figures(plan).values())
    sites = {task.site for task in course_of(plan).tasks if task.site is not None}
    assert len(world.texts) == len(sites) == 7
    assert (*world.get_xlim(), *world.get_ylim()) == WORLD
    short = handmade_plan(scenarios.from_mapping(short_plan()))
    part = figures(short)["ground_track"]().axes[0]
    (west, east), (south, north) = part.get_xlim(), part.get_ylim()
    assert east - west == pytest.approx(2.0 * (north - south)) and east - west < 120.0
    for name, latitude, longitude in (("Finnmark", 70.5, 26.0), ("Svalbard", 78.23, 15.39)):
        assert west < longitude < east and south < latitude < north
        assert [text.xy for text in part.texts if text.get_text() == name] == [
            pytest.approx((longitude, latitude))
        ]


def test_a_part_of_the_map_stays_on_the_map():
    def around(longitudes, latitudes):
        return part_around(np.radians(longitudes), np.radians(latitudes))

    polar = around([0.0, 10.0], [80.0, 89.0])
    assert polar.north == 90.0 and polar.east - polar.west == pytest.approx(58.0)
    edge = around([170.0, 175.0], [0.0, 0.0])
    assert edge.east == 180.0
    assert around([-179.0, 179.0], [0.0, 0.0]) == WORLD
    assert around([0.0, 0.0], [-75.0, 75.0]) == WORLD
