"""Sections that a turn in free time adds to a report."""

from __future__ import annotations

from jaxatt.problems.sections import Sections
from jaxatt.problems.time_optimal.report.names import attributes, names, together
from jaxatt.problems.time_optimal.report.panels import costs_panel, mark_switches, panels
from jaxatt.problems.time_optimal.report.rows import rows, title
from jaxatt.problems.time_optimal.report.variables import variables

TIME_OPTIMAL = Sections(
    title=title,
    rows=rows,
    names=names,
    together=together,
    variables=variables,
    attributes=attributes,
    panels=panels,
    mark=mark_switches,
    starts=costs_panel,
)
