"""Sections that net power adds to a report."""

from __future__ import annotations

from jaxatt.problems.net_power.report.names import attributes, names, together, whole
from jaxatt.problems.net_power.report.panels import panels, shades, starts_panel
from jaxatt.problems.net_power.report.plan_figures import figures, overview
from jaxatt.problems.net_power.report.plan_table import plan_table
from jaxatt.problems.net_power.report.rows import rows, title
from jaxatt.problems.net_power.report.variables import LABELS, variables
from jaxatt.problems.sections import Sections

NET_POWER = Sections(
    title=title,
    rows=rows,
    names=names,
    together=together,
    whole=whole,
    labels=LABELS,
    variables=variables,
    attributes=attributes,
    panels=panels,
    shades=shades,
    figures=figures,
    table=plan_table,
    overview=overview,
    starts=starts_panel,
)
