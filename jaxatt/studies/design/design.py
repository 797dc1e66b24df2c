"""Find the best design of a study, and fly what it leads to."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.pipeline.solve import solve
from jaxatt.pipeline.solve_targets import solve_targets
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.numbers import number_at
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.settings import check_precision
from jaxatt.scenarios.loader import replace
from jaxatt.studies.design.descend import best_of, descend, excess
from jaxatt.studies.design.evaluate import Evaluation, Evaluator
from jaxatt.studies.design.reading import load_design, read_design
from jaxatt.studies.design.result import Design, Flown
from jaxatt.studies.design.study import DesignStudy
from jaxatt.studies.sweep.samples import Range, scattered

_ROUNDS = 4
_BETTER = 1e-5
"""Relative gain for which a descent begins again."""


def design(
    study: DesignStudy | Mapping[str, Any] | str | Path, report: Report | None = None
) -> Design:
    """Choose numbers of a scenario within their ranges by descent, and fly the answers.

    study : a bundled design study's name, a TOML file, or a mapping with the names of such a file.
    report : called by the host with (stage, designs that have just ended).

    The descent begins at the best of several designs spread over the ranges.  Where it ends, all
    targets are searched again from the scenario's own starts; it goes on where these know better.
    The last design is solved once more with another seed, and flown.

    Raises `ScenarioError` where the study makes no sense or its limit cannot be met.
    """
    check_precision()
    if isinstance(study, Mapping):
        study = read_design(study)
    elif not isinstance(study, DesignStudy):
        study = load_design(study)
    evaluator = Evaluator(study, report)
    unit = [Range(None, 0.0, 1.0)] * len(study.variables)
    spread = scattered("sobol", unit, study.points, study.seed)
    best = best_of(study, [evaluator.fresh(shares) for shares in spread])
    if not best.answered:
        raise ScenarioError(
            f"{study.origin}: none of {study.points} designs has an answer to all of its targets; "
            "narrow the ranges, or raise solver.starts under [fixed]"
        )
    for _ in range(_ROUNDS):
        evaluator.go_on_from(best)
        best = descend(evaluator, best)
        if excess(study, best.measured):
            best = _nearest(evaluator, best)
            continue
        again = evaluator.fresh(best.shares, best)
        settled = (again.measured >= best.measured * (1.0 - _BETTER)).all()
        best = again
        if settled:
            break
    return Design(study, tuple(evaluator.tried), best, _flown(study, best))


def _nearest(evaluator: Evaluator, best: Evaluation) -> Evaluation:
    """A design that keeps the limit of the study, from one that does not.

    Raises `ScenarioError`, which says how near to the limit a descent comes.
    """
    study = evaluator.study
    evaluator.go_on_from(best)
    nearest = descend(evaluator, best, minimise_measure=True)
    if not excess(study, nearest.measured):
        return nearest
    values = zip(study.names, nearest.values, strict=True)
    raise ScenarioError(
        f"{study.origin}: [at_most] {study.measure} = {study.at_most:g}: the least within the "
        f"ranges is {study.over_targets(nearest.measured):.6g}, with "
        + ", ".join(f"{name} = {value:.6g}" for name, value in values)
        + "; raise the limit or widen the ranges"
    )


def _flown(study: DesignStudy, best: Evaluation) -> Flown:
    """Answers of a design by an independent search with another seed, flown with fine steps."""
    scenario = study.scenario_at(best.shares)
    scenario = replace(scenario, {"solver.seed": (scenario.solver.seed + 1) % 2**31})
    if len(study.targets) > 1:
        found = solve_targets(scenario, study.targets, names=(study.measure,))
        return Flown(found.numbers[study.measure], found.reached)
    result = solve(scenario.aiming_at(study.targets[0]))
    measured = number_at(result.summary(), study.measure)
    return Flown(np.array([measured]), np.array([result.reached]), result)
