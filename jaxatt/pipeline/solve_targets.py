"""Solve one scenario for many targets: in batches where its family does so, else one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jaxatt.pipeline.solve import solve
from jaxatt.problems.registry import family_of
from jaxatt.records.targets import TargetAnswers
from jaxatt.report.numbers import number_at
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import SAMPLES
from jaxatt.scenarios import Scenario

CHECKED = (
    "attitude_error_deg",
    "rate_error_rad_s",
    "flight_error_deg",
    "flight_error_rad_s",
    "kkt.violation",
    "kkt.stationarity",
)
"""Names in `summary.json` of what shows how good an answer is, whatever the family."""


def solve_targets(
    scenario: Scenario,
    targets: Floats,
    report: Report | None = None,
    names: Sequence[str] | None = None,
) -> TargetAnswers:
    """Find the best answer of a scenario to each of many targets, and fly it again.

    targets : (M, 4), in place of the scenario's own q_ob; what else it asks for stays.
    report : called by the host with (`SAMPLES`, targets that have just ended).
    names : of the numbers that are returned beside `CHECKED`; those that the family maps by
    default.  They are not a number where there is none.
    """
    family = family_of(scenario)
    names = (*(family.mapped if names is None else names), *CHECKED)
    with np.errstate(over="ignore", invalid="ignore"):
        found = family.answer_targets(scenario, targets)
    tell = report or (lambda stage, done: None)
    if found is None:
        return _one_by_one(scenario, targets, names, tell)
    tell(SAMPLES, len(targets))
    nothing = np.full(len(targets), np.nan)
    return replace(found, numbers={name: found.numbers.get(name, nothing) for name in names})


def _one_by_one(
    scenario: Scenario, targets: Floats, names: Sequence[str], report: Report
) -> TargetAnswers:
    answers = []
    for q in targets:
        answers.append(solve(scenario.aiming_at(q)))
        report(SAMPLES, 1)
    summaries = [answer.summary() for answer in answers]
    return TargetAnswers(
        np.array([answer.reached for answer in answers]),
        {name: np.array([number_at(summary, name) for summary in summaries]) for name in names},
        np.stack([answer.phases[0].controls for answer in answers]),
        np.array([answer.phases[0].step for answer in answers]),
    )
