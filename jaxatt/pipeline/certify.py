"""Certificate of minimality: try every support that costs less than the answer, or as much.

What this shows is numerical: on each support Newton's method looks for torques that meet the
target, from rest and from random points, both ways round.  A support on which it arrives is
feasible beyond doubt; one on which it does not is very likely not.
"""

from __future__ import annotations

from pathlib import Path

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.hands_off.certificate import PhaseCertificate
from jaxatt.problems.hands_off.report.certificate import Certificate
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.registry import family_of
from jaxatt.records.phase import Phase
from jaxatt.runtime.chunks import Report

MOST_SUPPORTS = 50_000
"""Supports that are tried without being asked for more, both ways round counted once."""


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
    if objective is not None:
        scenario = scenarios.replace(scenario, {"objective.kind": objective})
    family = family_of(scenario)
    family.check_certifiable(scenario)
    scenario = scenarios.replace(scenario, {"objective.terminal": "reach"})
    result = solve(scenario, starts=starts, seed=seed, report=report)
    phases: list[PhaseCertificate] = []
    start = PhaseStart()
    for phase in result.phases:
        certified = family.certify(result.scenario, start, phase, most, result.seed, report)
        phases.append(certified)
        start = start.following(phase, _end_of(phase))
    return Certificate(result, tuple(phases))


def _end_of(phase: Phase) -> InitialState | None:
    if "q_ob" not in phase.series:
        return None
    end = len(phase.controls)
    return InitialState(*(phase.series[name][end] for name in ("q_ob", "omega_ob", "omega_bw")))
