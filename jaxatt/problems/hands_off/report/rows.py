"""Rows of the table of an answer of sparse control."""

from __future__ import annotations

from jaxatt.problems.answer import Answer
from jaxatt.problems.hands_off.report.final_times import cost_text, final_time_text
from jaxatt.problems.sections import Block, Row, Rows, objective_rows
from jaxatt.records.wording import indices_text, plural, short


def rows(answer: Answer) -> Rows:
    """Rows of active intervals, windows, a free final time, valves and the printed cost."""
    windows: tuple[Row, ...] = (
        ("outside the cheap windows", lambda b: str(b["active_outside_windows"])),
        ("weighted count", lambda b: short(b["weighted_active_intervals"])),
    )
    return Rows(
        answer=(
            ("active intervals", _active),
            ("their indices", lambda b: indices_text(b["active_interval_indices"])),
            ("for the bias of the wheels", _for_bias),
            ("final time [s]", final_time_text),
            ("cost with its time", cost_text),
            *(windows if answer.scenario.windows else ()),
        ),
        flown=(("after quantisation", _quantised),),
        cost=objective_rows(answer.phases[0]),
    )


def _active(block: Block) -> str:
    return f"{block['active_intervals']} ({block['relative_sparsity_percent']:.3g} % of all)"


def _for_bias(block: Block) -> str:
    added = block["intervals_for_bias"]
    if added is None:
        return ""
    return f"{plural(added, 'interval')} more" if added else "no interval more"


def _quantised(block: Block) -> str:
    valves = block.get("quantised")
    if valves is None:
        return ""
    return (
        f"{valves['status']} ({valves['mode']}): {valves['active_intervals']} active, "
        f"{short(valves['attitude_error_deg'])} deg, {short(valves['rate_error_rad_s'])} rad/s"
        + (f"; {valves['obstacle']}" if valves["obstacle"] else "")
    )
