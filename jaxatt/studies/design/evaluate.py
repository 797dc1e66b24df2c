"""Answers of a scenario at a design, and how they change with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.registry import family_of
from jaxatt.problems.sensitive import OptimalObjective
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.studies.design.study import DesignStudy
from jaxatt.studies.sensitivity.parameters import difference

STAGE = "designs"
_STEP = 1e-5
"""Of a range, over which the arguments of an answer are differentiated."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """A design that was tried.

    shares, values : (D,), of the variables, as shares of their ranges and as they are.
    measured : (M,), of the best answer to every target; infinite where none was found.
    slopes : (M, D), its derivatives by the shares.
    found : what the family's search returned, from which a design close by is answered.
    fresh : whether it was searched from its own starts.
    """

    shares: Floats
    values: Floats
    measured: Floats
    slopes: Floats
    found: Sequence[Any]
    fresh: bool

    @property
    def answered(self) -> bool:
        """Whether all targets have an answer."""
        return bool(np.isfinite(self.measured).all())


class Evaluator:
    """Evaluates designs, and remembers them in order.

    A design is answered from the answers of the one before, which follows one minimum smoothly;
    a `fresh` one from the scenario's own starts.
    """

    def __init__(self, study: DesignStudy, report: Report | None = None):
        self.study, self._report = study, report
        self.tried: list[Evaluation] = []
        self._last: Evaluation | None = None

    def __call__(self, shares: Floats) -> Evaluation:
        """Evaluate shares (D,) of the ranges, from the answers of the design before."""
        shares = np.clip(shares, 0.0, 1.0)
        known = next((e for e in self.tried[::-1] if np.array_equal(e.shares, shares)), None)
        if known is not None:
            return known
        return self._evaluated(shares, None if self._last is None else self._last.found, None)

    def go_on_from(self, known: Evaluation) -> None:
        """Answer the next design from the answers of this one."""
        self._last = known

    def fresh(self, shares: Floats, known: Evaluation | None = None) -> Evaluation:
        """Evaluate from the scenario's own starts; answers that are `known` and better are kept."""
        return self._evaluated(np.clip(shares, 0.0, 1.0), None, known)

    def _evaluated(
        self, shares: Floats, near: Sequence[Any] | None, known: Evaluation | None
    ) -> Evaluation:
        study = self.study
        scenario = study.scenario_at(shares)
        family = family_of(scenario)
        aimed = [scenario.aiming_at(q) for q in study.targets]
        found = list(family.search_targets(scenario, study.targets, near, None))
        pairs = zip(aimed, found, strict=True)
        answers = [family.objective(each, PhaseStart(), one) for each, one in pairs]
        for k, each in enumerate(aimed if known is not None else ()):
            if known is not None and known.measured[k] < answers[k].value:
                found[k] = known.found[k]
                answers[k] = family.objective(each, PhaseStart(), found[k])
        measured = np.array([answer.value for answer in answers])
        slopes = self._slopes(shares, answers)
        new = Evaluation(shares, study.values(shares), measured, slopes, tuple(found), near is None)
        self.tried.append(new)
        if new.answered:
            self._last = new
        if self._report is not None:
            self._report(STAGE, 1)
        return new

    def _slopes(self, shares: Floats, answers: Sequence[OptimalObjective]) -> Floats:
        """Derivatives (M, D) of the objectives by the shares; zero where there is no answer.

        The arguments of an answer are smooth in the numbers of its scenario, so that differences
        give their derivatives; nothing is solved for that.
        """
        study = self.study
        steps = _STEP * np.eye(len(shares))
        ends = [(np.minimum(shares + by, 1.0), np.maximum(shares - by, 0.0)) for by in steps]
        changed = [
            (study.scenario_at(ahead), study.scenario_at(behind), float((ahead - behind).sum()))
            for ahead, behind in ends
        ]
        rows = np.zeros((len(answers), len(shares)))
        for k, (q, answer) in enumerate(zip(study.targets, answers, strict=True)):
            if not np.isfinite(answer.value):
                continue
            along = []
            for name, (ahead, behind, width) in zip(study.names, changed, strict=True):
                first, last = (answer.arguments(each.aiming_at(q)) for each in (ahead, behind))
                slope = difference(first, last, width, answer.args)
                if isinstance(slope, str):
                    raise ScenarioError(f"{study.origin}: [[design]] {name}: {slope}; drop it")
                along.append(slope)
            rows[k] = answer.along(jax.tree.map(lambda *leaves: np.stack(leaves), *along))
        return rows
