"""Descend on the numbers of a design with the derivatives of the answers.

Source: Kraft (1988), "A software package for sequential quadratic programming", as SciPy's SLSQP.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from jaxatt.runtime.arrays import Floats
from jaxatt.studies.design.evaluate import Evaluation, Evaluator
from jaxatt.studies.design.study import DesignStudy
from jaxatt.studies.tables import MEAN

MET = 1e-5
"""Relative excess over a limit that counts as none."""
_AWAY = 10.0
"""Times what the descent began with, instead of a target without an answer: a step too far."""
_PRECISION = 1e-7
_MOST_PASSES = 40


def descend(evaluator: Evaluator, begin: Evaluation, minimise_measure: bool = False) -> Evaluation:
    """The best design that a descent from `begin` leads to.

    minimise_measure : and not a variable, to learn which limits can be met.

    The worst of several targets is a variable of its own, above all of them: the greatest of
    smooth functions is not smooth where two are equal, which is where its least value often is.
    """
    study, size = evaluator.study, len(begin.shares)
    scale = float(np.abs(begin.measured).max()) or 1.0
    measures = minimise_measure or study.minimised is None
    worst = measures and study.over != MEAN
    least = np.zeros(size + worst)
    least[size if worst else study.minimised or 0] = 1.0

    def measured(shares: Floats) -> Floats:
        return np.minimum(evaluator(shares).measured / scale, _AWAY)

    def mean(shares: Floats) -> float:
        return float(measured(shares).mean())

    def mean_slope(shares: Floats) -> Floats:
        return evaluator(shares).slopes.mean(axis=0) / scale

    def room(x: Floats) -> Floats:
        """What the measures leave of the worst, or of their limit, (M,) or (1,)."""
        most = x[size] if worst else (study.at_most or 0.0) / scale
        return np.atleast_1d(most - _folded(study, measured(x[:size])))

    def room_slope(x: Floats) -> Floats:
        slope = -np.atleast_2d(_folded(study, evaluator(x[:size]).slopes)) / scale
        return np.concatenate([slope, np.ones((len(slope), int(worst)))], axis=1)

    smooth = measures and not worst
    problem: dict[str, Any] = {
        "fun": mean if smooth else lambda x: float(least @ x),
        "jac": mean_slope if smooth else lambda x: least,
        "x0": np.append(begin.shares, [begin.measured.max() / scale] * worst),
        "bounds": [(0.0, 1.0)] * size + [(None, None)] * worst,
        "constraints": () if smooth else {"type": "ineq", "fun": room, "jac": room_slope},
    }
    before = len(evaluator.tried)
    found = scipy.optimize.minimize(
        **problem, method="SLSQP", options={"ftol": _PRECISION, "maxiter": _MOST_PASSES}
    )
    evaluator(found.x[:size])
    return best_of(study, [begin, *evaluator.tried[before:]], measures)


def _folded(study: DesignStudy, rows: Floats) -> Floats:
    """One row a target, or their mean."""
    return rows.mean(axis=0) if study.over == MEAN else rows


def excess(study: DesignStudy, measured: Floats) -> float:
    """By how much of it a limit is exceeded; 0 where it is kept."""
    if study.at_most is None:
        return 0.0
    over = study.over_targets(measured) / study.at_most - 1.0
    return over if over > MET else 0.0


def best_of(
    study: DesignStudy, tried: list[Evaluation], minimise_measure: bool = False
) -> Evaluation:
    """The best of some designs; where none keeps the limit, the one that exceeds it least."""

    def worth(one: Evaluation) -> tuple[float, float]:
        over = study.over_targets(one.measured)
        if minimise_measure or study.minimised is None:
            return 0.0, over
        return excess(study, one.measured), float(one.shares[study.minimised])

    return min(tried, key=worth)
