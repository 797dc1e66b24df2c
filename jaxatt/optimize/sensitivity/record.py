"""Record of how an answer changes with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.optimize.sensitivity.regularity import Flag
from jaxatt.runtime.arrays import Floats

_SHOWN = 20


@dataclass(frozen=True, eq=False)
class OneSided:
    """Derivatives to both sides of P parameters, where weakly active limits make branches.

    forwards, backwards : name of a variable -> (P, ...), derivatives as a parameter grows and as it
    shrinks, both per unit of growth; NaN where no branch fits.
    """

    forwards: Mapping[str, Floats]
    backwards: Mapping[str, Floats]


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of a converged answer by P parameters, each a number.

    names : of the parameters.  values : (P,).  objective : of the polished answer.
    by_parameter : (P,), derivatives of the objective.
    variables : name -> (P, ...), derivatives of the variables; NaN where the answer is not regular,
    see `one_sided`.
    active : name of a limit that holds -> its multiplier, what the objective gains for every unit
    by which it is relaxed.
    flags : what is not regular about the answer; empty where all derivatives hold.
    one_sided : None unless limits hold weakly and nothing else is amiss.
    """

    names: tuple[str, ...]
    values: Floats
    objective: float
    by_parameter: Floats
    variables: Mapping[str, Floats]
    active: Mapping[str, float]
    flags: tuple[Flag, ...]
    one_sided: OneSided | None = None

    @property
    def regular(self) -> bool:
        """Whether the answer moves smoothly with all parameters."""
        return not self.flags

    @property
    def shares(self) -> Floats:
        """Per cent of the objective for a per cent of each parameter, (P,); NaN where it is 0."""
        size = abs(self.objective) or np.nan
        return np.asarray(self.by_parameter * np.where(self.values, self.values, np.nan) / size)

    @property
    def order(self) -> list[int]:
        """Parameters, those with the largest shares first, then by derivative."""
        share = np.nan_to_num(np.abs(self.shares))
        return [int(i) for i in np.lexsort((-np.abs(np.nan_to_num(self.by_parameter)), -share))]

    def __getitem__(self, name: str) -> float:
        """Derivative of the objective by a parameter."""
        if name not in self.names:
            raise KeyError(f"{name}: no such parameter; there are {', '.join(self.names)}")
        return float(self.by_parameter[self.names.index(name)])

    def __repr__(self) -> str:
        width = max((len(name) for name in self.names), default=0)
        lines = [f"objective {self.objective:.10g}, {len(self.active)} limits hold"]
        shares = self.shares
        for i in self.order[:_SHOWN]:
            share = f"{shares[i]:+.4g} % a per cent" if np.isfinite(shares[i]) else ""
            rate = f"{self.by_parameter[i]:+.8g}"
            lines.append(f"  {self.names[i]:<{width}}  {rate:>16}  {share}".rstrip())
        lines += [f"  {flag.kind.value}: {flag.sentence}" for flag in self.flags]
        return "\n".join(lines)
