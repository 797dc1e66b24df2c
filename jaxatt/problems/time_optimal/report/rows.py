"""Rows of the table of a turn in free time."""

from __future__ import annotations

from collections.abc import Callable

from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Block, Row, Rows, plain_title
from jaxatt.problems.time_optimal.record import time_optimum
from jaxatt.records.wording import objective_title, short

_SHOWN = 6


def title(answer: Answer) -> str:
    """Text of what is minimised, with the price of effort where it has one."""
    objective = answer.scenario.objective
    if objective.kind == "time-effort":
        return f"{objective_title(objective.kind)}, rho = {objective.effort_weight:g}"
    return plain_title(answer)


def rows(answer: Answer) -> Rows:
    """Rows of time, effort, switches and optimality."""
    weighted = time_optimum(answer.phases[0]).effort_weight > 0.0
    priced: list[Row] = [("cost [s]", lambda b: short(b["cost"], 8))] if weighted else []
    found: list[Row] = [
        ("final time [s]", lambda b: f"{short(b['final_time_s'], 7)}"),
        ("interval [s]", lambda b: short(b["step_s"], 5)),
        ("control effort [(N m)^2 s]", lambda b: short(b["control_effort"], 6)),
        *priced,
        ("with exact switches [s]", _alone(_resolved)),
        ("switches [s]", _alone(_switches)),
        ("transcription", _alone(_transcription)),
        ("optimality", _alone(_optimality)),
    ]
    return Rows(answer=found)


def _alone(show: Callable[[Block], str]) -> Callable[[Block], str]:
    """Function that shows a value of one phase, and nothing of several together."""
    return lambda block: "" if block["time_optimum"] is None else show(block)


def _switches(block: Block) -> str:
    times = block["time_optimum"]["switch_times_s"]
    found = [
        f"{name}: {', '.join(short(t) for t in each[:_SHOWN])}{' ...' if each[_SHOWN:] else ''}"
        for name, each in times.items()
        if each
    ]
    return "; ".join(found) or "none from limit to limit"


def _resolved(block: Block) -> str:
    found = block["time_optimum"]["resolved_final_time_s"]
    return "" if found is None else short(found, 8)


def _transcription(block: Block) -> str:
    used = block["time_optimum"]["transcription"]
    word = {"rk4": "Runge-Kutta", "euler": "forward Euler"}[used["integration"]]
    name = {"mrp": "MRP"}.get(used["attitude"], used["attitude"])
    return f"{name}, {word}; by its own count {short(used['attitude_error_deg'], 3)} deg off"


def _optimality(block: Block) -> str:
    kkt, found = block["kkt"], block["time_optimum"]
    share = 100.0 * found["share_at_best"]
    minima = "1 minimum" if found["minima"] == 1 else f"{found['minima']} minima"
    return (
        f"violation {short(kkt['violation'], 2)}, stationarity {short(kkt['stationarity'], 2)}; "
        f"{share:.3g} % of the starts at the best of {minima}"
    )
