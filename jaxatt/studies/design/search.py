"""Descend on the numbers of a design with the derivatives of the answers.

Each evaluation solves every case from its starts and differentiates the answers by the numbers;
sequential quadratic programming (SciPy's SLSQP) takes it from there.

Source: Kraft (1988), "A software package for sequential quadratic programming".
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize

from jaxatt.pipeline.solve import solve
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.report.result import Result
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.design.result import DesignResult, Evaluation
from jaxatt.studies.design.study import MEAN, NUMBERS, WORST, Design, load_design
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer

_PRECISION = 1e-8
_MET = 1e-5
"""Relative excess over `at_most` that counts as none."""


@dataclass
class _Path:
    """Evaluations so far; what was evaluated is not solved again."""

    design: Design
    scenarios: list[Scenario]
    report: Report | None
    done: list[Evaluation]

    def at(self, shares: Floats) -> Evaluation:
        """Objectives of all cases, and their derivatives by the shares."""
        values = self.design.values(shares)
        for known in self.done:
            if np.array_equal(known.values, values):
                return known
        objectives, slopes = [], []
        for scenario in self.scenarios:
            changed = self.design.changed(scenario, values)
            answer = sensitive_answer(changed)
            found = directions_of(changed, answer.arguments, self.design.fields)
            moves = answer.optimum.answer.moves(found.along)
            objectives.append(answer.optimum.answer.objective)
            slopes.append(np.asarray(moves.objective) * (self.design.upper - self.design.lower))
        new = Evaluation(values, np.array(objectives), np.array(slopes))
        if not (np.isfinite(new.objectives).all() and np.isfinite(new.slopes).all()):
            named = ", ".join(
                f"{f} = {v:.6g}" for f, v in zip(self.design.fields, values, strict=True)
            )
            raise ScenarioError(
                f"{self.design.name}: at {named} an answer has no derivative; narrow the range of "
                "the numbers or take more starts"
            )
        self.done.append(new)
        if self.report is not None:
            self.report("designs tried", 1)
        return new


def design(
    study: Design | str | Path,
    first: Floats | None = None,
    *,
    most: int = 40,
    report: Report | None = None,
) -> DesignResult:
    """Find the best numbers of a design within their ranges, and fly what they lead to.

    study : a `Design`, or the TOML file of one.
    first : (d,), numbers to begin with; the middles of the ranges by default.
    most : evaluations.  report : called with ("designs tried", 1).

    Raises `ScenarioError` where a case cannot be solved or differentiated.
    """
    check_precision()
    design = study if isinstance(study, Design) else load_design(study)
    path = _Path(design, [design.of_case(case) for case in design.cases], report, [])
    d = len(design.fields)
    begin = np.full(d, 0.5)
    if first is not None:
        begin = (np.asarray(first, float) - design.lower) / (design.upper - design.lower)
        if begin.shape != (d,) or not ((begin >= 0.0) & (begin <= 1.0)).all():
            raise ScenarioError(
                f"{design.name}: first = {first!r} is not within the ranges of its {d} numbers"
            )
    scale = float(np.abs(path.at(begin).objectives).max()) or 1.0
    found = minimize(**_problem(path, begin, scale), method="SLSQP", options=_options(most))
    best = _best(path, found.x[:d])
    scenarios = [design.changed(scenario, best.values) for scenario in path.scenarios]
    flown: tuple[Result, ...] = tuple(solve(scenario) for scenario in scenarios)
    return DesignResult(design, tuple(path.done), best, flown, bool(found.success))


def _options(most: int) -> dict[str, Any]:
    return {"ftol": _PRECISION, "maxiter": most}


def _problem(path: _Path, begin: Floats, scale: float) -> dict[str, Any]:
    """Arguments of SciPy's `minimize`; with "worst" the last variable is the worst objective."""
    design, d = path.design, len(begin)
    constraints: list[dict[str, Any]] = []
    extra = int(design.minimise == WORST)

    def padded(slopes: Floats) -> Floats:
        return np.concatenate([slopes, np.zeros((len(slopes), extra))], axis=1)

    if design.at_most is not None:
        most = design.at_most
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda z: (most - path.at(z[:d]).objectives) / scale,
                "jac": lambda z: -padded(path.at(z[:d]).slopes) / scale,
            }
        )
    if extra:
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda z: z[d] - path.at(z[:d]).objectives / scale,
                "jac": lambda z: padded(-path.at(z[:d]).slopes / scale) + np.eye(1, d + 1, d),
            }
        )
    bounds: list[tuple[float | None, float | None]] = [(0.0, 1.0)] * d + [(None, None)] * extra
    start = np.append(begin, [path.at(begin).objectives.max() / scale] * extra)
    if design.minimise == NUMBERS:
        fun, jac = (lambda z: z.mean()), (lambda z: np.full(d, 1.0 / d))
    elif design.minimise == MEAN:
        fun = lambda z: path.at(z).objectives.mean() / scale  # noqa: E731
        jac = lambda z: path.at(z).slopes.mean(axis=0) / scale  # noqa: E731
    else:
        fun, jac = (lambda z: z[d]), (lambda z: np.eye(1, d + 1, d)[0])
    return {"fun": fun, "x0": start, "jac": jac, "bounds": bounds, "constraints": constraints}


def _best(path: _Path, shares: Floats) -> Evaluation:
    """The best evaluation that keeps the limit, or the last where none does."""
    path.at(shares)
    design = path.design

    def worth(e: Evaluation) -> float:
        if design.at_most is not None and e.objectives.max() > design.at_most * (1.0 + _MET):
            return np.inf
        if design.minimise == NUMBERS:
            return float(((e.values - design.lower) / (design.upper - design.lower)).mean())
        return float(e.objectives.mean() if design.minimise == MEAN else e.objectives.max())

    costs = [worth(e) for e in path.done]
    return path.done[int(np.argmin(costs))] if np.isfinite(costs).any() else path.done[-1]
