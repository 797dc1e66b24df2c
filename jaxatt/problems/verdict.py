"""Verdict of an independent re-simulation on an answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True)
class Verdict:
    """Errors and violations of S controls by independent re-simulation; leading axis S.

    errors : name -> (S,) error, e.g. "attitude" [rad]; tolerances : name -> allowed error.
    limit_violation : (S,) largest excess over a control limit, in units of the controls.
    margin_violation : (S,) largest violation of a path constraint, relative to its limit.
    least_limit : smallest of the control limits, against which an excess is rounding.
    """

    errors: dict[str, Floats]
    tolerances: dict[str, float]
    limit_violation: Floats
    margin_violation: Floats
    least_limit: float = 1.0

    LIMIT_TOLERANCE = 1e-9
    MARGIN_TOLERANCE = 1e-6

    @property
    def within_limits(self) -> npt.NDArray[np.bool_]:
        """Whether all controls are within their limits, to rounding, (S,)."""
        return self.limit_violation <= self.LIMIT_TOLERANCE * self.least_limit

    @property
    def arrives(self) -> npt.NDArray[np.bool_]:
        """Whether all errors and control limits are within tolerance, whatever the path, (S,)."""
        ok = self.within_limits
        for name, error in self.errors.items():
            ok &= error <= self.tolerances[name]
        return ok

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """Whether all errors, limits and path constraints are within tolerance, (S,)."""
        return self.arrives & (self.margin_violation <= self.MARGIN_TOLERANCE)

    def pick(self, rows: npt.NDArray[np.int64]) -> Verdict:
        """Select the verdicts of some of the controls."""
        return Verdict(
            {name: error[rows] for name, error in self.errors.items()},
            self.tolerances,
            self.limit_violation[rows],
            self.margin_violation[rows],
            self.least_limit,
        )

    @staticmethod
    def join(parts: Sequence[Verdict]) -> Verdict:
        """Concatenate several verdicts."""
        return Verdict(
            {name: np.concatenate([p.errors[name] for p in parts]) for name in parts[0].errors},
            parts[0].tolerances,
            np.concatenate([p.limit_violation for p in parts]),
            np.concatenate([p.margin_violation for p in parts]),
            parts[0].least_limit,
        )

    @property
    def shortfall(self) -> Floats:
        """Largest error in units of its tolerance, (S,); infinite where not a number."""
        worst = np.zeros_like(self.limit_violation)
        for name, error in self.errors.items():
            worst = np.maximum(worst, np.nan_to_num(error / self.tolerances[name], nan=np.inf))
        return worst
