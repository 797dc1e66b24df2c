"""Tables of results for the terminal and for notebooks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Block, Row
from jaxatt.records.phase import Phase
from jaxatt.records.wording import LIMITS, limit_label, limit_text, plural, short
from jaxatt.report.do_nothing import do_nothing_sentence
from jaxatt.report.family import sections_of
from jaxatt.report.free_roll import roll_words
from jaxatt.report.summary import summary

_ERRORS = (
    ("attitude", "attitude error [deg]", "attitude_error_deg"),
    ("rate", "rate error [rad/s]", "rate_error_rad_s"),
    ("waypoint", "waypoint error [deg]", "waypoint_error_deg"),
    ("state", "state error", "state_error"),
)
"""Name in `Phase.errors`, label of its row, name in the summary."""


def result_table(result: Answer) -> Table:
    """Table of the answer, its errors, the outcome of all starts and the time it took."""
    own = sections_of(result).table(result)
    if own is not None:
        return own
    numbers = summary(result)
    blocks: list[Block] = list(numbers["legs"])
    names = [f"leg {block['leg']}" for block in blocks]
    if not blocks or len(blocks) > 1:
        blocks, names = [*blocks, numbers], [*names, "together" if names else ""]
    if numbers["alternative"] is not None:
        blocks, names = [numbers, numbers["alternative"]], ["lowest J", "best that reaches"]
    table = Table(
        title=Text(f"{result.scenario.title} ({sections_of(result).title(result)})", style="bold"),
        caption=_caption(result, numbers),
        box=box.SIMPLE_HEAD,
        show_header=len(names) > 1,
        title_justify="left",
        caption_justify="left",
    )
    table.add_column("")
    for name in names:
        table.add_column(name)
    for label, show in _rows(result):
        cells = [show(block) for block in blocks]
        if any(cells):
            # As Text: rich would read "[deg]" in a plain string as a style.
            table.add_row(Text(label), *(Text(c) if isinstance(c, str) else c for c in cells))
    return table


def _caption(result: Answer, numbers: Mapping[str, Any]) -> Text:
    time = ", ".join(f"{name} {value:.1f} s" for name, value in numbers["time_s"].items() if value)
    made = (
        f"{time}; seed {result.seed}, {result.device}, {result.precision}, "
        f"{', '.join(f'{name} {version}' for name, version in result.versions.items())}"
    )
    notes = [f"Note: {note}" for note in result.notes]
    return Text("\n".join(filter(None, [do_nothing_sentence(result), *notes, made])))


def _rows(result: Answer) -> list[Row]:
    first, unitless = result.phases[0], result.scenario.vehicle is None
    unit = first.section.control_unit
    own = sections_of(result).rows(result)
    known = [key for key, *_ in _ERRORS]
    return [
        ("status", _status),
        ("obstacle", lambda b: str(b["obstacle"])),
        *own.answer,
        *((words, _error(first, key, name)) for key, words, name in _ERRORS),
        *(
            (f"{key} error", _error(first, key, f"{key}_error"))
            for key in first.errors
            if key not in known
        ),
        ("roll left free", lambda b: roll_words(b["free_roll"])),
        ("flight uncertain by", _uncertain),
        *own.flown,
        *(
            (limit_label(extreme.kind, extreme.name), _limit(index))
            for index, extreme in enumerate(first.pointing.extremes if first.pointing else ())
        ),
        *(
            (f"wheels avoid {band.name}", _band(index))
            for index, band in enumerate(first.wheel_bands)
        ),
        (
            f"over the limit{'' if unitless else f' [{unit}]'}",
            lambda b: short(b["max_torque_violation_Nm"]),
        ),
        (f"L1 effort{'' if unitless else f' [{unit} s]'}", lambda b: short(b["l1_effort_Nms"], 7)),
        *own.cost,
        ("starts", _starts),
    ]


def _limit(index: int) -> Callable[[Block], str | Text]:
    """Function that states how a phase kept one cone or rate limit; several phases say it each."""

    def show(block: Block) -> str | Text:
        entries = block["pointing"]
        if index >= len(entries) or "leg" in entries[index]:
            return ""
        kind, met = entries[index]["kind"], entries[index]["satisfied"]
        word, unit = LIMITS[kind]
        value, allowed = entries[index][f"{word}_{unit}"], entries[index][f"allowed_{unit}"]
        text = limit_text(kind, value, allowed, entries[index]["time_s"], met)
        return Text(text, style="" if met else "bold red")

    return show


def _band(index: int) -> Callable[[Block], str | Text]:
    """Function that states how a phase kept one band of wheel speeds; several say it each."""

    def show(block: Block) -> str | Text:
        entries = block["wheel_bands"]
        if index >= len(entries) or "leg" in entries[index]:
            return ""
        met = entries[index]["satisfied"]
        return Text(entries[index]["outcome"], style="" if met else "bold red")

    return show


def _status(block: Block) -> Text:
    reached = block["status"] == "reached"
    words = "reached the target" if reached else "NOT reached"
    return Text(words, style="green" if reached else "bold red")


def _error(phase: Phase, name: str, key: str) -> Callable[[Block], str]:
    factor = math.degrees(1.0) if key.endswith("_deg") else 1.0

    def show(block: Block) -> str:
        if name not in phase.tolerances:
            return ""
        allowed = phase.tolerances[name] * factor
        met = block[key] is not None and block[key] <= allowed
        return f"{short(block[key]) or 'not finite'} ({'<' if met else '>'} {allowed:.3g})"

    return show


def _uncertain(block: Block) -> str:
    """What the flight may be wrong by, and the steps that it and the search took."""
    if block["flight_steps"] is None:
        return ""
    steps = f"{plural(int(block['flight_steps']), 'Runge-Kutta step')} an interval"
    if block["search_steps"] is not None:
        steps += f", {int(block['search_steps'])} in the search"
    angle, rate = block["flight_error_deg"], block["flight_error_rad_s"]
    return f"{short(angle, 2)} deg, {short(rate, 2)} rad/s ({steps})"


def _starts(block: Block) -> str:
    starts = block["starts"]
    return (
        f"{starts['reached_target']} of {starts['requested']} reached, "
        f"{starts['converged']} converged, {starts['distinct_minima']} distinct minima"
    )
