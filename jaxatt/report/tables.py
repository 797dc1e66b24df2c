"""Tables of results for the terminal and for notebooks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Block, Row
from jaxatt.records.phase import Phase
from jaxatt.records.wording import LIMITS, indices_text, limit_label, limit_text, short
from jaxatt.report.family import sections_of
from jaxatt.report.summary import do_nothing_cost, summary

_ERRORS = (
    ("attitude", "attitude error [deg]", "attitude_error_deg"),
    ("rate", "rate error [rad/s]", "rate_error_rad_s"),
    ("waypoint", "waypoint error [deg]", "waypoint_error_deg"),
    ("state", "state error", "state_error"),
)
"""Name in `Phase.errors`, label of its row, name in the summary."""


def result_table(result: Answer) -> Table:
    """Table of the answer, its errors, the outcome of all starts and the time it took."""
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


def comparison_table(
    title: str,
    rows: Sequence[Mapping[str, Any]],
    printed: Mapping[str, Any] | None = None,
    findings: Sequence[str] = (),
) -> Group:
    """Table of obtained and printed values, followed by the quality of the answers.

    rows : as `jaxatt.studies.comparison.Row.to_dict` gives them.
    printed : the scenario's printed values.
    findings : sentences below the tables.
    """
    toy = all(row["state_error"] is not None for row in rows)
    errors: tuple[str, ...] = ("attitude [deg]", "rate [rad/s]")
    if toy:
        errors = ("state error", "in tolerance")
    passing = any(row["waypoint_error_deg"] is not None for row in rows)
    errors += ("waypoint [deg]",) if passing else ()
    timed = len({row["final_time_s"] for row in rows}) > 1
    errors += ("final time [s]",) if timed else ()
    sparsity = any(row["printed"]["relative_sparsity_percent"] is not None for row in rows)
    found = _controllers(
        (
            "active (printed)",
            *(("% of all (printed)",) if sparsity else ()),
            "intervals",
            "outside windows (printed)",
            "weighted",
            "optimised in",
        ),
        title,
    )
    judged = _controllers(
        (*errors, "L1 effort", "J", "starts reached", "time [s] (printed)"), "Flown again"
    )
    for row in rows:
        name = Text(row["controller"], style="" if row["reached"] else "yellow")
        found.add_row(
            name,
            _beside(row["active_intervals"], row["printed"]["active_intervals"]),
            *([_share(row)] if sparsity else []),
            indices_text(row["active_interval_indices"]),
            _beside(row["active_outside_windows"], row["printed"]["active_outside_windows"]),
            short(row["weighted_active_intervals"]),
            row["axes"],
        )
        worst = [short(row["state_error"], 3), "yes" if row["reached"] else "no"]
        if not toy:
            worst = [short(row["attitude_error_deg"], 3), short(row["rate_error_rad_s"], 3)]
        if passing:
            worst.append(short(row["waypoint_error_deg"], 3))
        if timed:
            worst.append(short(row["final_time_s"]))
        judged.add_row(
            name,
            *worst,
            short(row["l1_effort_Nms"]),
            short(row["objective_total"]),
            "" if row["starts"] is None else f"{row['starts_reached']} of {row['starts']}",
            _beside(short(row["time_s"], 3), short(row["printed"]["cpu_time_s"], 4)),
        )
    told = [Text(sentence) for sentence in findings]
    return Group(found, judged, *([_printed(printed)] if sparsity and printed else []), *told)


def sparsity_table(study: Mapping[str, Any]) -> Group:
    """Table of a study of relative sparsity, from its `to_dict`."""
    tables = []
    for key, title in (
        ("against_intervals", "Relative sparsity against intervals"),
        ("against_limit", "Relative sparsity against torque limit"),
    ):
        table = Table(title=Text(title, style="bold"), box=box.SIMPLE_HEAD, title_justify="left")
        for header in ("N", "limit [N m]", "active", "found [%]", "one axis [%]", "bound [%]"):
            table.add_column(Text(header), justify="right")
        for point in study[key]:
            table.add_row(
                str(point["intervals"]),
                short(point["torque_limit_Nm"]),
                str(point["active_intervals"]) if point["reached"] else "not reached",
                short(point["percent"]) if point["reached"] else "",
                short(point["eigenaxis_percent"]),
                short(point["bound_percent"]),
            )
        tables.append(table)
    return Group(*tables)


def _share(row: Mapping[str, Any]) -> str:
    printed = row["printed"]["relative_sparsity_percent"]
    return _beside(short(row["relative_sparsity_percent"]), short(printed))


def _printed(printed: Mapping[str, Any]) -> Text:
    """Text of what the source prints besides counts."""
    values = {
        name: value
        for block in printed.values()
        if isinstance(block, Mapping)
        for name, value in block.items()
    }
    listed = ", ".join(f"{name} {value}" for name, value in values.items())
    return Text(f"Printed in table {printed.get('table', '?')}: {listed}.")


def _controllers(headers: Sequence[str], title: str) -> Table:
    table = Table(
        title=Text(title, style="bold"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
        padding=(0, 1, 0, 0),
        pad_edge=False,
    )
    table.add_column("controller", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="left" if header == "intervals" else "right")
    return table


def do_nothing_sentence(result: Answer) -> str:
    """Sentence for cases whose printed cost is lowest at rest, or tumbling, off the target."""
    cost = do_nothing_cost(result)
    if result.scenario.objective.terminal != "penalty" or cost is None:
        return ""
    others = [phase.alternative for phase in result.phases if phase.alternative is not None]
    against = ""
    if len(others) == len(result.phases):
        total = sum(other.total_cost for other in others)
        against = f" against {total:.4g} for the best start that reaches"
    if not any(phase.active.any() for phase in result.phases):
        return f"The printed objective prefers not moving: J = {cost:.4g}{against}."
    turned = [phase for phase in result.phases if not phase.reached and "rate" in phase.errors]
    if not turned:
        return ""
    worst = max(turned, key=lambda phase: phase.errors["attitude"])
    return (
        "The printed objective prefers tumbling to braking: "
        f"J = {sum(phase.total_cost for phase in result.phases):.4g} ends "
        f"{math.degrees(worst.errors['attitude']):.3g} deg off at "
        f"{math.degrees(worst.errors['rate']):.3g} deg/s{against}; "
        f"not moving costs {cost:.4g}."
    )


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
        *own.flown,
        *(
            (limit_label(extreme.kind, extreme.name), _limit(index))
            for index, extreme in enumerate(first.pointing.extremes if first.pointing else ())
        ),
        (
            f"over the limit{'' if unitless else ' [N m]'}",
            lambda b: short(b["max_torque_violation_Nm"]),
        ),
        (f"L1 effort{'' if unitless else ' [N m s]'}", lambda b: short(b["l1_effort_Nms"], 7)),
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


def _starts(block: Block) -> str:
    starts = block["starts"]
    return (
        f"{starts['reached_target']} of {starts['requested']} reached, "
        f"{starts['converged']} converged, {starts['distinct_minima']} distinct minima"
    )


def _beside(ours: Any, printed: Any) -> str:
    mine = "-" if ours is None or ours == "" else str(ours)
    return mine if printed is None or printed == "" else f"{mine} ({printed})"
