"""Improve a plan over its tasks' boundaries, after they were solved one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from jaxatt.problems.family import Improved, PhaseStart
from jaxatt.problems.net_power.answers import Answers, judged, phase_manoeuvre
from jaxatt.problems.net_power.build import carried_on, options_of
from jaxatt.problems.net_power.corrected import corrected
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.manoeuvre import Motion, WheelLimits
from jaxatt.problems.net_power.plan.joint.assemble import Leg
from jaxatt.problems.net_power.plan.joint.solve import JointAnswer, solve_jointly
from jaxatt.problems.net_power.record import energy_of, with_starts_of
from jaxatt.problems.net_power.wheels.within_limits import (
    MOST_SEARCHES,
    keeping_to,
    may_bind,
    stricter,
)
from jaxatt.problems.scenario import Scenario
from jaxatt.records.phase import Phase
from jaxatt.runtime.chunks import Report

_SUBSTEPS = 4
"""Runge-Kutta steps an interval, as many as the harvests have by themselves."""
_WORSE = 1e-10
"""Of the solar energy, by which a plan may earn less and still be no worse."""


def improved(
    scenario: Scenario, phases: Sequence[Phase], found: Sequence[Any], report: Report | None
) -> Improved | None:
    """Solve all tasks together from where the sequence ended, and fly the plan again.

    The better of both is kept: one that reaches, then the one of more net energy.  None where there
    is nothing to improve together.
    """
    options = options_of(scenario)
    harvests = sum(task.searched for task in options.tasks)
    if not options.joint or not harvests or len(options.tasks) < 2:
        return None
    if scenario.objective.terminal != "reach":
        return None
    limits = [_limits_of(answers) for answers in found]
    for _ in range(MOST_SEARCHES + 1):
        legs = [_leg(scenario, index, phase) for index, phase in enumerate(phases)]
        legs = _within(legs, limits)
        limits = [leg.manoeuvre.limits for leg in legs]
        answer = solve_jointly(legs, scenario.horizon.substeps or _SUBSTEPS, report=report)
        again, answers, stricter_ones = _flown(scenario, answer, phases, limits)
        if not any(stricter_ones):
            break
        limits = [new or old for new, old in zip(stricter_ones, limits, strict=True)]
    before = energy_of(phases)
    gain = energy_of(again).net - before.net
    missed = [sum(not phase.reached for phase in some) for some in (again, phases)]
    kept = missed[0] < missed[1] or (missed[0] == missed[1] and gain >= -_WORSE * before.solar)
    words = f"the solver {answer.status.meaning}, {answer.iterations} passes"
    if missed[0] > missed[1]:
        words += f"; {missed[0]} tasks would not be flown as asked"
    extra = {"joint": {"gain_J": gain, "kept": kept, "words": words}}
    if not kept:
        return Improved(tuple(phases), tuple(found), extra)
    return Improved(tuple(again), tuple(answers), extra)


def _start(index: int, phase: Phase) -> PhaseStart:
    """Where a phase began, from its record."""
    series = phase.series
    motion = Motion(*(series[name][0] for name in ("q_ib", "omega_ib", "omega_bw")))
    charge = float(series["charge"][0]) if "charge" in series else 0.0
    return PhaseStart(index, phase.start_time, carried_on(motion, charge))


def _leg(scenario: Scenario, index: int, phase: Phase) -> Leg:
    task = options_of(scenario).tasks[index]
    start = PhaseStart() if index == 0 else _start(index, phase)
    decided = options_of(scenario).satellite.decided_dipole
    return Leg(
        task,
        phase_manoeuvre(scenario, start),
        phase.series["q_ib"],
        phase.series["omega_ib"],
        phase.series["omega_bw"],
        phase.series["torque_wheels"] if task.searched else None,
        phase.series["dipole"][:-1] if task.searched and decided else None,
    )


def _limits_of(answers: Any) -> WheelLimits | None:
    """Limits that a task's answer was found with."""
    return None if answers is None or answers.solved is None else answers.solved.limits


def _within(legs: Sequence[Leg], limits: Sequence[WheelLimits | None]) -> list[Leg]:
    """The tasks with the limits of their wheels, all of them or, where none binds, none."""
    if not any(limits):
        return list(legs)
    return [
        replace(leg, manoeuvre=keeping_to(leg.manoeuvre, own))
        for leg, own in zip(legs, limits, strict=True)
    ]


def _flown(
    scenario: Scenario,
    answer: JointAnswer,
    before: Sequence[Phase],
    limits: Sequence[WheelLimits | None],
) -> tuple[list[Phase], list[Answers], list[WheelLimits | None]]:
    """Fly all tasks again, each from the flown end of the one before.

    The torques are corrected for where that is: tiny rates that are left turn far until the end.
    Limits are those of the search; returned are stricter ones for the tasks that break them.
    """
    watched = may_bind(options_of(scenario).satellite.craft.wheels)
    start = PhaseStart()
    phases: list[Phase] = []
    answers: list[Answers] = []
    broken: list[WheelLimits | None] = []
    for torque, dipole, old, kept in zip(answer.torque, answer.dipole, before, limits, strict=True):
        solved = None
        if torque is not None:
            torque = corrected(phase_manoeuvre(scenario, start), torque, dipole)
            solved = Solved(
                torque[None],
                None if dipole is None else dipole[None],
                np.full(1, np.nan),
                np.array([int(answer.status)]),
                np.array([answer.violation]),
                np.array([answer.stationarity]),
                np.array([answer.iterations]),
                limits=kept,
            )
        asked = None
        if watched and solved is not None:
            asked, _ = stricter(replace(phase_manoeuvre(scenario, start), limits=kept), solved)
        broken.append(asked)
        answers.append(Answers(solved))
        phase, end = judged(scenario, start, answers[-1])
        phases.append(with_starts_of(phase, old))
        start = start.following(phase, end)
    return phases, answers, broken
