"""An answer of a family with what its sensitivities need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class SensitiveAnswer:
    """A polished answer as a function of what it depends on.

    optimum : the answer.  arguments : a changed scenario -> what the optimum depends on, a pytree
    of the same structure; what was decided by counting, such as a support, stays as it is.
    label, unit : of the objective.  notes : what is held fixed, in words.
    """

    optimum: Optimum
    arguments: Callable[[Scenario], Any]
    label: str
    unit: str
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class OptimalObjective:
    """The objective of an answer as a function of what it depends on.

    value : at the answer; infinite where there is none.  args : what it depends on, a pytree.
    arguments : a changed scenario -> the same of that one.
    along : directions (P, ...) of `args` -> derivatives (P,) of the objective.
    """

    value: float
    args: Any
    arguments: Callable[[Scenario], Any]
    along: Callable[[Any], Floats]
