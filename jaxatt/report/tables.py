"""Tables for the terminal and for notebooks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.problems.answer import Answer
from jaxatt.records.phase import Phase
from jaxatt.records.wording import LIMITS, OBJECTIVES, indices_text, limit_label, limit_text, short
from jaxatt.report.final_times import cost_text, final_time_text
from jaxatt.report.summary import do_nothing_cost, summary
from jaxatt.report.time_rows import time_rows

_Block = Mapping[str, Any]


def result_table(result: Answer) -> Table:
    """What came out, how well it was met, what all starts did and how long it took."""
    numbers = summary(result)
    blocks: list[_Block] = list(numbers["legs"])
    names = [f"leg {block['leg']}" for block in blocks]
    if not blocks or len(blocks) > 1:
        blocks, names = [*blocks, numbers], [*names, "together" if names else ""]
    if numbers["alternative"] is not None:
        blocks, names = [numbers, numbers["alternative"]], ["lowest J", "best that reaches"]
    objective = result.scenario.objective
    kind = f"{OBJECTIVES[objective.kind]}, {objective.terminal}"
    if objective.kind == "time-effort":
        kind = f"{OBJECTIVES[objective.kind]}, rho = {objective.effort_weight:g}"
    table = Table(
        title=Text(f"{result.scenario.title} ({kind})", style="bold"),
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
    """Rows of a comparison: what was found with the printed values beside, then how good it is.

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
    """A study of relative sparsity, as its own `to_dict` gives it."""
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
    """What the source prints beyond counts, by name."""
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
    """Say so where the printed cost is lowest at rest, or tumbling, short of the target."""
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


def _rows(result: Answer) -> list[tuple[str, Callable[[_Block], str | Text]]]:
    first = result.phases[0]
    toy = "state" in first.errors
    rows: list[tuple[str, Callable[[_Block], str | Text]]] = [
        ("status", _status),
        ("obstacle", lambda b: str(b["obstacle"])),
        *(
            (
                ("active intervals", _active),
                ("their indices", lambda b: indices_text(b["active_interval_indices"])),
                ("final time [s]", final_time_text),
                ("cost with its time", cost_text),
            )
            if first.time_optimum is None
            else time_rows(first.time_optimum.effort_weight > 0.0)
        ),
    ]
    if result.scenario.windows:
        rows += [
            ("outside the cheap windows", lambda b: str(b["active_outside_windows"])),
            ("weighted count", lambda b: short(b["weighted_active_intervals"])),
        ]
    rows += [
        ("attitude error [deg]", _error(first, "attitude", "attitude_error_deg")),
        ("rate error [rad/s]", _error(first, "rate", "rate_error_rad_s")),
        ("waypoint error [deg]", _error(first, "waypoint", "waypoint_error_deg")),
        ("state error", _error(first, "state", "state_error")),
        ("after quantisation", _quantised),
        *(
            (limit_label(extreme.kind, extreme.name), _limit(index))
            for index, extreme in enumerate(first.pointing.extremes if first.pointing else ())
        ),
        (
            f"over the limit{'' if toy else ' [N m]'}",
            lambda b: short(b["max_torque_violation_Nm"]),
        ),
        (f"L1 effort{'' if toy else ' [N m s]'}", lambda b: short(b["l1_effort_Nms"], 7)),
    ]
    if first.time_optimum is None:
        rows += [
            ("objective J", lambda b: short(b["objective"]["total"], 6)),
            *((f"  {part}", _part(part)) for part in first.objective),
        ]
    rows.append(("starts", _starts))
    return rows


def _limit(index: int) -> Callable[[_Block], str | Text]:
    """How a block kept to one cone or rate limit; of phases together each says it for itself."""

    def show(block: _Block) -> str | Text:
        entries = block["pointing"]
        if index >= len(entries) or "leg" in entries[index]:
            return ""
        kind, met = entries[index]["kind"], entries[index]["satisfied"]
        word, unit = LIMITS[kind]
        value, allowed = entries[index][f"{word}_{unit}"], entries[index][f"allowed_{unit}"]
        text = limit_text(kind, value, allowed, entries[index]["time_s"], met)
        return Text(text, style="" if met else "bold red")

    return show


def _status(block: _Block) -> Text:
    reached = block["status"] == "reached"
    words = "reached the target" if reached else "NOT reached"
    return Text(words, style="green" if reached else "bold red")


def _active(block: _Block) -> str:
    return f"{block['active_intervals']} ({block['relative_sparsity_percent']:.3g} % of all)"


def _quantised(block: _Block) -> str:
    valves = block.get("quantised")
    if valves is None:
        return ""
    return (
        f"{valves['status']} ({valves['mode']}): {valves['active_intervals']} active, "
        f"{short(valves['attitude_error_deg'])} deg, {short(valves['rate_error_rad_s'])} rad/s"
        + (f"; {valves['obstacle']}" if valves["obstacle"] else "")
    )


def _error(phase: Phase, name: str, key: str) -> Callable[[_Block], str]:
    factor = math.degrees(1.0) if key.endswith("_deg") else 1.0

    def show(block: _Block) -> str:
        if name not in phase.tolerances:
            return ""
        allowed = phase.tolerances[name] * factor
        met = block[key] is not None and block[key] <= allowed
        return f"{short(block[key]) or 'not finite'} ({'<' if met else '>'} {allowed:.3g})"

    return show


def _part(name: str) -> Callable[[_Block], str]:
    return lambda block: short(block["objective"][name])


def _starts(block: _Block) -> str:
    starts = block["starts"]
    return (
        f"{starts['reached_target']} of {starts['requested']} reached, "
        f"{starts['converged']} converged, {starts['distinct_minima']} distinct minima"
    )


def _beside(ours: Any, printed: Any) -> str:
    mine = "-" if ours is None or ours == "" else str(ours)
    return mine if printed is None or printed == "" else f"{mine} ({printed})"
