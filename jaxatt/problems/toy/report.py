"""Sections that sparse control of a toy adds to a report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.panels import lines, pulses, references
from jaxatt.problems.answer import Answer
from jaxatt.problems.hands_off.report.sections import HANDS_OFF
from jaxatt.problems.sections import Panel
from jaxatt.records.labels import Variable
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import timeline

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def control(axes: Axes, answer: Answer) -> None:
    """Draw the control of a toy system."""
    line = timeline(answer.phases)
    values, limit = line.intervals["control"][:, 0], answer.scenario.control.limit
    pulses(axes, line.edges, values, 0, "u", limit)
    axes.set_ylabel("control")


def states(axes: Axes, answer: Answer) -> None:
    """Draw the states of a toy system with dotted references."""
    line = timeline(answer.phases)
    values = line.nodes["state"]
    lines(axes, line.time, values, [f"x{'₁₂'[i]}" for i in range(values.shape[1])])
    for phase, (start, end) in zip(answer.phases, line.spans, strict=True):
        references(axes, start, end, phase.reference["state"])
    axes.set_ylabel("state")


def panels(answer: Answer, common: Mapping[str, Panel]) -> dict[str, Panel]:
    """Panels of control and states, in place of those that any system has."""
    return {"control": control, "state": states}


def coordinates(phase: Phase) -> dict[str, Variable]:
    """Names of the components of the state."""
    components = np.array([f"x{i + 1}" for i in range(phase.series["state"].shape[1])])
    return {"component": (("component",), components, {"long_name": "state component"})}


TOY = replace(
    HANDS_OFF,
    panels=panels,
    coordinates=coordinates,
    labels={
        "state": (("time", "component"), "1", "state"),
        "control": (("interval", "input"), "1", "control"),
        "state_reference": (("component",), "1", "target state"),
    },
)
