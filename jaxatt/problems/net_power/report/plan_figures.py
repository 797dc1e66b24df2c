"""Figures of a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.plan.report.ground_track import ground_track
from jaxatt.problems.net_power.plan.report.timeline import timeline_figure
from jaxatt.problems.net_power.report.plan_course import course_of, is_plan

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


def overview(answer: Answer) -> Picture | None:
    """Timeline of a plan; None for a single manoeuvre."""
    if not is_plan(answer):
        return None
    found = answer.phases[0].section.headline(answer.phases)
    vehicle = answer.scenario.vehicle
    wheels = None if vehicle is None else vehicle.wheels
    title = f"{answer.scenario.title}\n{found}, {answer.status}"
    return timeline_figure(course_of(answer), title, wheels)


def figures(answer: Answer) -> Mapping[str, Callable[[], Picture]]:
    """Ground track of a plan whose orbit has an epoch."""
    orbit = answer.scenario.orbit
    if not is_plan(answer) or orbit is None or orbit.days is None:
        return {}
    flown = answer.scenario.options.satellite.orbit
    return {"ground_track": lambda: ground_track(course_of(answer), flown, answer.scenario.title)}
