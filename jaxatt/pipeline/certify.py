"""Certificate of minimality: try every support that costs less than the answer, or as much.

What this shows is numerical: on each support Newton's method looks for torques that meet the
target, from rest and from random points, both ways round.  A support on which it arrives is
feasible beyond doubt; one on which it does not is very likely not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.certificate import ClassRecord, PhaseCertificate
from jaxatt.problems.hands_off.report.certificate import Certificate
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.enumeration import (
    SupportClass,
    classes_up_to,
    enumerate_class,
    group_weights,
    masks_of,
)
from jaxatt.problems.hands_off.search.polish import Method, polish
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Task
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import TIME_KINDS
from jaxatt.records.phase import Phase
from jaxatt.runtime.chunks import Report, chunk_for

MOST_SUPPORTS = 50_000
"""Supports that are tried without being asked for more, both ways round counted once."""

_ATTEMPTS = 4
_FLOWN = 32
_SECONDS_A_SUPPORT = 2e-4


def certify(
    scenario: scenarios.Scenario | str | Path,
    *,
    objective: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    most: int = MOST_SUPPORTS,
    report: Report | None = None,
) -> Certificate:
    """Solve a scenario, then try every support that costs less than the answer, or as much.

    objective, starts, seed : as in `solve`.  most : supports of a class beyond which it counts as
    out of reach.  report : called by the host with (stage, supports tried).

    The target is a constraint here (`terminal = "reach"`), whatever the scenario says.  Raises
    `ScenarioError` where enumeration means nothing: for L1, where time is minimised, and with path
    constraints.
    """
    if most < 1:
        raise ValueError(f"most = {most}: expected at least one support")
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    kind = objective or scenario.objective.kind
    if kind in ("l1", *TIME_KINDS):
        raise scenarios.ScenarioError(
            f'objective.kind = "{kind}": its minimum is not a matter of supports; certify "l0" or '
            '"moving-l0"'
        )
    scenario = scenarios.replace(scenario, {"objective.kind": kind, "objective.terminal": "reach"})
    _checked(scenario)
    result = solve(scenario, starts=starts, seed=seed, report=report)
    phases: list[PhaseCertificate] = []
    initial_state: InitialState | None = None
    for index, phase in enumerate(result.phases):
        task = build_slew(
            result.scenario,
            index,
            initial_state,
            enforce_speed_limits=False,
            final_time=phase.final_time,
            start_time=phase.start_time,
        )
        phases.append(_certify_phase(task, phase, most, result.seed, report))
        initial_state = _end_of(phase)
    return Certificate(result, tuple(phases))


def _checked(scenario: scenarios.Scenario) -> None:
    task = build_slew(scenario)
    if task.system.response is None or (isinstance(task, SlewTask) and task.pointing):
        raise scenarios.ScenarioError(
            f"{scenario.name}: has path constraints (wheel speed limits, cones, limits on the "
            "rate), under which supports cannot be tried one by one; certify it without them"
        )


def _end_of(phase: Phase) -> InitialState | None:
    if "q_ob" not in phase.series:
        return None
    end = len(phase.controls)
    return InitialState(*(phase.series[name][end] for name in ("q_ob", "omega_ob", "omega_bw")))


def _certify_phase(
    task: Task, phase: Phase, most: int, seed: int, report: Report | None
) -> PhaseCertificate:
    if not phase.reached:
        return PhaseCertificate(phase, math.inf, (), (), None, None, False)
    weight = group_weights(task)
    cost = float(np.nansum(weight[support_of(task, phase.controls)]))
    classes = classes_up_to(task, cost)
    tie = cost * (1.0 - 1e-9)
    rate = _SECONDS_A_SUPPORT
    signs = (1.0, -1.0) if isinstance(task, SlewTask) else (1.0,)
    rows = chunk_for(len(phase.starts.status))  # as in the search: nothing is compiled again

    def tried(kind: SupportClass, attempts: int, thorough: bool) -> ClassRecord:
        nonlocal rate
        if kind.number > most:
            return ClassRecord(kind, None, None, len(signs) * rate * attempts * kind.number)
        stage = f"trying supports of {kind.size}"
        progress = None if report is None else lambda done: report(stage, done)
        method = Method("l0", rows=rows, progress=progress)
        ways = [
            enumerate_class(task, kind, sign, method, attempts, seed, thorough) for sign in signs
        ]
        seconds = sum(way.seconds for way in ways)
        if kind.number >= 500:
            rate = seconds / (len(signs) * attempts * kind.number)
        return ClassRecord(kind, ways[0], ways[1] if len(ways) > 1 else None, seconds)

    same = [kind for kind in classes if kind.cost >= tie]
    equal = tuple(tried(kind, 1, False) for kind in same)
    own = np.argwhere(support_of(task, phase.controls))
    if not _finds(equal, own):
        # Limits bind too much for the quick way, as the answer's own support shows.
        equal = tuple(tried(kind, 1, True) for kind in same)
    cheaper = tuple(tried(kind, _ATTEMPTS, True) for kind in classes if kind.cost < tie)
    best, effort, long_way = _best(task, equal, rows)
    consistent = _finds(equal, own) or not all(record.tried for record in equal)
    return PhaseCertificate(phase, cost, cheaper, equal, best, effort, long_way, consistent)


def _finds(records: Sequence[ClassRecord], support: npt.NDArray[np.int64]) -> bool:
    """Whether a support that is known to reach was found again."""
    return any(
        way is not None
        and way.groups.shape[1:] == support.shape
        and bool((way.reached & (way.groups == support[None]).all(axis=(1, 2))).any())
        for record in records
        for way in (record.short, record.long)
    )


def _best(
    task: Task, records: Sequence[ClassRecord], rows: int
) -> tuple[npt.NDArray[np.int64] | None, float | None, bool]:
    """The support of least L1 effort among those that reach, polished and verified in flight."""
    ways: list[tuple[float, npt.NDArray[np.int64], float]] = []
    for record in records:
        for sign, way in ((1.0, record.short), (-1.0, record.long)):
            if way is None:
                continue
            order = np.argsort(np.where(way.reached, way.effort, np.inf))[:_FLOWN]
            ways += [(float(way.effort[i]), way.groups[i], sign) for i in order if way.reached[i]]
    ways = sorted(ways, key=lambda entry: entry[0])[:_FLOWN]
    if not ways:
        return None, None, False
    masks = np.concatenate([masks_of(task, groups[None]) for _, groups, _ in ways])
    signs = np.asarray([sign for _, _, sign in ways])
    rest = np.zeros((len(ways), task.intervals, task.size))
    ended = polish(task, rest, masks, signs, Method("l0", rows=rows))
    flown = np.where(ended.verdict.reached, ended.rank[:, -1], np.inf)
    index = int(np.argmin(flown))
    if not np.isfinite(flown[index]):
        return None, None, False
    return ways[index][1], float(flown[index]), bool(signs[index] < 0)
