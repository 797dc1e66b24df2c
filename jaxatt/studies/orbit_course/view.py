"""Table and figure of an orbit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.world_map import track, world_map
from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import plural
from jaxatt.studies.orbit_course.course import Course

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


_SHADOW = "#555555"


def course_table(numbers: Mapping[str, Any]) -> Table:
    """Table with one row a number, and the notes below."""
    notes = [f"Note: {note}" for note in numbers["notes"]]
    table = dense_table(numbers["title"], Text("\n".join(notes)) if notes else None)
    table.add_column("")
    table.add_column("")
    for label, value in _rows(numbers):
        table.add_row(Text(label), Text(value))
    return table


def _rows(numbers: Mapping[str, Any]) -> list[tuple[str, str]]:
    rows = [("source", numbers["source"]), ("start", numbers["epoch"])]
    if numbers["age_days"] is not None:
        rows.append(
            (
                "age of the elements",
                f"{numbers['age_days']:.2f} days, off by about {numbers['off_by_km']:.0f} km",
            )
        )
    rows.append(("osculating elements", _elements(numbers["osculating_elements"])))
    if numbers["mean_elements"] is not None:
        mean = dict(numbers["mean_elements"])
        rows.append((f"mean elements ({mean.pop('theory')})", _elements(mean)))
    low, high = numbers["altitude_km"]
    count, longest = len(numbers["eclipses"]), numbers["longest_eclipse_s"]
    first, last = numbers["beta_deg"]
    eclipse = (
        f"{numbers['eclipse_percent']:.1f} % of {numbers['duration_s'] / 3600.0:.2f} h, "
        f"{plural(count, 'passage')}, the longest {longest / 60.0:.2f} min"
    )
    rows += [
        ("revolution, by osculating elements", f"{numbers['period_s'] / 60.0:.2f} min"),
        ("altitude", f"{low:.1f} to {high:.1f} km"),
        ("highest latitude", f"{numbers['highest_latitude_deg']:.2f} deg"),
        ("in eclipse", eclipse),
        ("sun above the orbit's plane (beta)", f"{first:.2f} to {last:.2f} deg"),
    ]
    if numbers["field_uT"] is not None:
        rows.append(("magnetic field", "{:.1f} to {:.1f} uT".format(*numbers["field_uT"])))
    return rows


_SHORT = {
    "semi_major_axis_km": "a {:.3f} km",
    "mean_motion_rev_day": "n {:.8f} rev/day",
    "eccentricity": "e {:.6f}",
    "inclination_deg": "i {:.4f} deg",
    "raan_deg": "node {:.4f} deg",
    "argument_of_periapsis_deg": "perigee {:.4f} deg",
    "true_anomaly_deg": "true anomaly {:.4f} deg",
    "mean_anomaly_deg": "mean anomaly {:.4f} deg",
}


def _elements(values: Mapping[str, float]) -> str:
    return ", ".join(_SHORT[key].format(value) for key, value in values.items())


def course_figure(course: Course, title: str) -> Picture:
    """Ground track on a map; light, altitude, beta and field over time below."""
    figure = picture(11.0, 9.5, title)
    axes = figure.subplot_mosaic(
        [["map", "map"], ["light", "altitude"], ["beta", "field"]], height_ratios=[3.2, 1.0, 1.0]
    )
    world_map(axes["map"])
    under = np.where(course.light < 0.5, course.latitude, math.nan)
    track(axes["map"], course.longitude, course.latitude, color=colour(0), linewidth=1.4, zorder=3)
    track(axes["map"], course.longitude, under, color=_SHADOW, alpha=0.35, linewidth=6.0, zorder=2)
    start = np.degrees([course.longitude[0], course.latitude[0]])
    axes["map"].plot(*start, marker="o", color="black", markersize=5, zorder=5)
    figure.legend(
        handles=[
            Line2D([], [], color=colour(0), linewidth=1.4, label="ground track"),
            Line2D([], [], color=_SHADOW, alpha=0.35, linewidth=6.0, label="eclipse"),
            Line2D([], [], color="black", marker="o", linestyle="", label="start"),
        ],
        frameon=False,
        fontsize=8,
        loc="outside lower center",
        ncols=3,
    )
    hours = course.times / 3600.0
    strips: dict[str, tuple[Any, str]] = {
        "light": (100.0 * course.light, "sun's disk in sight [%]"),
        "altitude": (1e-3 * course.altitude, "altitude [km]"),
        "beta": (np.degrees(course.beta), "beta [deg]"),
    }
    if course.field is None:
        axes["field"].set_visible(False)
    else:
        strips["field"] = (1e6 * np.linalg.norm(course.field, axis=1), "magnetic field [uT]")
    for index, (name, (values, label)) in enumerate(strips.items()):
        axes[name].plot(hours, values, color=colour(index), linewidth=1.2)
        axes[name].set_ylabel(label, fontsize=8)
        axes[name].ticklabel_format(axis="y", useOffset=False)
        tidy(axes[name])
    for name in ("beta", "field"):
        axes[name].set_xlabel("time [h]", fontsize=8)
    return figure
