"""An answer of a family with what its sensitivities need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.problems.scenario import Scenario


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
