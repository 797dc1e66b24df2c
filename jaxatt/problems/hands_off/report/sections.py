"""Sections that sparse control of a spacecraft adds to a report."""

from __future__ import annotations

from jaxatt.problems.hands_off.report.names import names, together, whole
from jaxatt.problems.hands_off.report.panels import figures, panels, shades
from jaxatt.problems.hands_off.report.rows import rows
from jaxatt.problems.hands_off.report.variables import variables
from jaxatt.problems.sections import Sections

HANDS_OFF = Sections(
    rows=rows,
    names=names,
    together=together,
    whole=whole,
    variables=variables,
    panels=panels,
    shades=shades,
    figures=figures,
)
