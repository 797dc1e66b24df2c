"""Sections that a family adds to a report: rows, names, variables, panels and figures.

Each is a plain function on records.  A family gives those it has something to say in; with none at
all a report still tells, draws and archives what every answer has.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from jaxatt.problems.answer import Answer
from jaxatt.records.labels import Label, Variable
from jaxatt.records.phase import Phase
from jaxatt.records.wording import objective_title, short
from jaxatt.runtime.arrays import Flags

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


Block = Mapping[str, Any]
"""One phase, or all of them together, as the summary has it."""

Row = tuple[str, Callable[[Block], str | Text]]
"""Label of a row of the table, and what it shows of a block; a row without text is left out."""

Panel = Callable[["Axes", Answer], None]
"""Draws one quantity over the time of all phases."""


@dataclass(frozen=True)
class Rows:
    """Rows of a result's table, by their place in it.

    answer : below the status.  flown : below the errors.  cost : below the effort.
    """

    answer: Sequence[Row] = ()
    flown: Sequence[Row] = ()
    cost: Sequence[Row] = ()


@dataclass(frozen=True, eq=False)
class Shade:
    """Intervals that every panel shades.

    mask : (I,), over the intervals of all phases.  style : of matplotlib's `axvspan`.
    """

    mask: Flags
    words: str
    style: Mapping[str, Any]


def objective_rows(phase: Phase) -> tuple[Row, ...]:
    """Rows of the cost and its named parts."""

    def part(name: str) -> Callable[[Block], str]:
        return lambda block: short(block["objective"][name])

    total: Row = ("objective J", lambda block: short(block["objective"]["total"], 6))
    return (total, *((f"  {name}", part(name)) for name in phase.objective))


def plain_title(answer: Answer) -> str:
    """Text of what is minimised, and of how the target enters."""
    objective = answer.scenario.objective
    return f"{objective_title(objective.kind)}, {objective.terminal}"


def plain_rows(answer: Answer) -> Rows:
    """Rows of the final time, and of the cost with its parts."""
    time: Row = ("final time [s]", lambda block: short(block["final_time_s"], 7))
    return Rows(answer=(time,), cost=objective_rows(answer.phases[0]))


def all_null(blocks: Sequence[Block]) -> Block:
    """Null entries for the family's own names of several phases together."""
    return dict.fromkeys(blocks[0])


@dataclass(frozen=True)
class Sections:
    """Functions with which a family adds to a report.

    title : what is minimised, for the head of the table.
    rows : its rows of the table.
    names : its names in the summary of one phase.  together : the same of several phases, from what
        `names` gave for each.  whole : its names of the whole answer.
    labels : axes, unit and words of its own series and references in the archive; others get axes
        called after the series.
    coordinates : its coordinates in the archive, of one phase.
    variables : its variables in the archive, of one of the answer's phases.
    attributes : its attributes of the archive.
    panels : all panels in their order, from those that every answer has.
    mark : draws into a panel of torques; "body", "wheels" or "thrusters", and which one of them, or
        None for all.
    shades : intervals that every panel shades.
    figures : what draws figures of its own, by name.
    table, overview : table and overview of an answer in place of those that every answer has, or
        None for those; where there are many phases, one row or one band a phase.
    starts : draws how all starts of a phase ended; None for effort against active intervals.
    """

    title: Callable[[Answer], str] = plain_title
    rows: Callable[[Answer], Rows] = plain_rows
    names: Callable[[Phase], Block] = lambda phase: {}
    together: Callable[[Sequence[Block]], Block] = all_null
    whole: Callable[[Answer], Block] = lambda answer: {}
    labels: Mapping[str, Label] = field(default_factory=dict)
    coordinates: Callable[[Phase], Mapping[str, Variable]] = lambda phase: {}
    variables: Callable[[Phase, Sequence[Phase]], Mapping[str, Variable]] = lambda phase, all_: {}
    attributes: Callable[[Answer], Block] = lambda answer: {}
    panels: Callable[[Answer, Mapping[str, Panel]], Mapping[str, Panel]] = lambda answer, common: (
        common
    )
    mark: Callable[[Axes, Answer, str, int | None], None] = lambda axes, answer, kind, only: None
    shades: Callable[[Answer], Sequence[Shade]] = lambda answer: ()
    figures: Callable[[Answer], Mapping[str, Callable[[], Picture]]] = lambda answer: {}
    table: Callable[[Answer], Table | None] = lambda answer: None
    overview: Callable[[Answer], Picture | None] = lambda answer: None
    starts: Callable[[Axes, Phase], None] | None = None
