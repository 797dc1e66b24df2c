"""A design study: numbers of a scenario to be chosen, what is minimised, and for which targets."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.loader import from_mapping
from jaxatt.studies.sweep.study import Varied
from jaxatt.studies.tables import MEAN


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """A checked design study.

    scenario : with what is fixed.  whole : its document, its vehicle written out.
    variables : the D numbers to be chosen.
    measure : name in `summary.json` of the objective of an answer.
    minimised : index of the variable that is minimised, or None where the measure is.
    at_most : of the measure; None where that is minimised.
    over : `MEAN` or `WORST`, of the measure over the targets.
    targets : (M, 4), as `Target.q_ob`.
    points : designs that are tried before the descent, spread over the ranges.
    document : of the study.
    """

    name: str
    title: str
    origin: str
    scenario: Scenario
    whole: Mapping[str, Any]
    variables: tuple[Varied, ...]
    measure: str
    minimised: int | None
    at_most: float | None
    over: str
    targets: Floats
    points: int
    seed: int
    document: Mapping[str, Any]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return tuple(variable.name for variable in self.variables)

    def values(self, shares: Floats) -> Floats:
        """Values (D,) of the variables at shares of their ranges, each from 0 to 1."""
        pairs = zip(self.variables, shares, strict=True)
        return np.array([float(each.range.at(np.asarray(share))) for each, share in pairs])

    def scenario_at(self, shares: Floats) -> Scenario:
        """The scenario of a design, with its own target."""
        document = copy.deepcopy(dict(self.whole))
        for variable, value in zip(self.variables, self.values(shares).tolist(), strict=True):
            variable.apply(document, value)
        return from_mapping(document, origin=self.scenario.origin, folder=self.scenario.folder)

    def over_targets(self, measured: Floats) -> float:
        """Mean or greatest of what was measured for all targets, (M,)."""
        return float(measured.mean() if self.over == MEAN else measured.max())
