"""Table of a plan: a row for each task, and totals as the source's table 5.7 has them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rich.table import Table
from rich.text import Text

from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.modes import HARVEST
from jaxatt.problems.net_power.record import Energy, energy_of, net_power
from jaxatt.problems.net_power.report.plan_course import is_plan
from jaxatt.records.dense_table import dense_table
from jaxatt.records.phase import Phase

_COLUMNS = ("mode", "start", "time\n[s]", "net\n[J]", "PD law\n[J]", "gain\n[J]", "gain\n[%]")
"""Beside the task's name, the only one that is folded where the terminal is narrow."""


def plan_table(answer: Answer) -> Table | None:
    """Table of a plan, 80 columns wide at least; None for a single manoeuvre."""
    if not is_plan(answer):
        return None
    table = dense_table(answer.scenario.title, _caption(answer))
    table.add_column("task", overflow="fold")
    for name in _COLUMNS:
        table.add_column(Text(name), justify="left" if name == "mode" else "right", no_wrap=True)
    orbit = answer.scenario.orbit
    days = None if orbit is None else orbit.days
    for phase in answer.phases:
        found = net_power(phase)
        table.add_row(
            _named(phase),
            found.mode,
            clock_text(phase.start_time, days),
            f"{phase.final_time:g}",
            *_energies(found.energy, gained=found.mode == HARVEST),
        )
    table.add_section()
    for words, of in totals(answer.phases):
        table.add_row(Text(words), "", "", "", *_energies(of, gained=True))
    return table


def _named(phase: Phase) -> Text:
    """Name of a task, and whether it fails."""
    name = Text(net_power(phase).task)
    return name if phase.reached else name.append(" (not flown)", style="bold red")


def totals(phases: Sequence[Phase]) -> list[tuple[str, Energy]]:
    """Energies of several tasks together, in the order of the source's table 5.7.

    There they are called total energy, total and net energy without imaging and comms, and the same
    excluding task 7, which is the longest.
    """
    harvests = [phase for phase in phases if net_power(phase).mode == HARVEST]
    found = [("all tasks", energy_of(phases))]
    if not harvests:
        return found
    found.append(("harvests", energy_of(harvests)))
    found.append(("loads aside", _unloaded(energy_of(harvests))))
    if len(harvests) > 1:
        longest = max(harvests, key=lambda phase: phase.final_time)
        words = f"but {net_power(longest).task}"
        rest = [phase for phase in phases if phase is not longest]
        kept = [phase for phase in harvests if phase is not longest]
        found.append((f"all {words}", energy_of(rest)))
        found.append((f"harvests {words}", energy_of(kept)))
        found.append(("loads aside", _unloaded(energy_of(kept))))
    return found


def _unloaded(energy: Energy) -> Energy:
    """The same without the loads of the other subsystems."""
    base = None if energy.baseline is None else energy.baseline + energy.loads
    return Energy(energy.solar, energy.actuation, 0.0, base)


def _energies(energy: Energy, gained: bool) -> list[str]:
    """Cells of energy, baseline and gain."""
    cells = [f"{energy.net:.1f}"]
    if energy.baseline is None:
        return [*cells, "", "", ""]
    gain = energy.net - energy.baseline
    share = f"{100.0 * gain / energy.baseline:+.3g}" if energy.baseline > 0.0 else "-"
    return [
        *cells,
        f"{energy.baseline:.1f}",
        f"{gain:+.1f}" if gained else "",
        share if gained else "",
    ]


def _caption(answer: Answer) -> Text:
    lines = [_reason(number, phase) for number, phase in enumerate(answer.phases, start=1)]
    lines += [_errors(answer), _charge(answer), _shadow(answer), _joint(answer)]
    lines += [f"Note: {note}" for note in answer.notes]
    time = ", ".join(f"{name} {value:.1f} s" for name, value in answer.time.items() if value)
    starts = max(len(phase.starts.status) for phase in answer.phases)
    lines.append(f"{time}; {starts} starts a harvest, seed {answer.seed}, {answer.device}")
    return Text("\n".join(filter(None, lines)))


def _reason(number: int, phase: Phase) -> str:
    if phase.reached:
        return ""
    return f'Task {number} "{net_power(phase).task}" is not flown as asked: {phase.failure_reason}.'


def _errors(answer: Answer) -> str:
    harvests = [p for p in answer.phases if net_power(p).mode == HARVEST and p.errors]
    if not harvests:
        return ""
    worst = {
        name: max(phase.errors.get(name, 0.0) for phase in harvests)
        for name in ("attitude", "rate")
    }
    return (
        f"Largest error at the end of a harvest: {math.degrees(worst['attitude']):.2g} deg, "
        f"{worst['rate']:.2g} rad/s."
    )


def _charge(answer: Answer) -> str:
    energy, floor = energy_of(answer.phases), answer.scenario.options.floor
    if energy.final_charge is None or energy.least_charge is None:
        return ""
    told = f", floor {floor / 3600.0:.4g} Wh" if np.isfinite(floor) else ""
    return (
        f"Charge: {energy.final_charge / 3600.0:.4g} Wh at the end, least "
        f"{energy.least_charge / 3600.0:.4g} Wh{told}."
    )


def _shadow(answer: Answer) -> str:
    """Entries into and exits from the umbra, told once where tasks share a passage."""
    orbit = answer.scenario.orbit
    days = None if orbit is None else orbit.days
    seen: dict[str, float] = {}
    for phase in answer.phases:
        for passage in net_power(phase).shadow:
            _note(seen, "entry", passage.umbra_entry)
            _note(seen, "exit", passage.umbra_exit)
    if not seen:
        return ""
    parts = [f"{words.split()[0]} {clock_text(time, days)}" for words, time in seen.items()]
    return f"Umbra: {', '.join(parts)}."


def _note(seen: dict[str, float], words: str, time: float) -> None:
    if math.isfinite(time):
        seen.setdefault(f"{words} {round(time)}", time)


def _joint(answer: Answer) -> str:
    joint = answer.extra.get("joint")
    if joint is None:
        return ""
    told = "kept" if joint["kept"] else "not kept"
    return (
        f"Improved together over the tasks' boundaries: {joint['gain_J']:+.3f} J over the sequence "
        f"({told}; {joint['words']})."
    )
