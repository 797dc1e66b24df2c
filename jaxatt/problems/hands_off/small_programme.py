"""A small programme on the support of a sparse answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jaxatt.optimize.dense.functions import Functions
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class SmallProgramme:
    """What is minimised on a support, from an answer.

    arguments : (task, its parameters aimed at the target) -> arguments of the functions.
    start : (n,), variables of the answer, the free controls first.
    names : of the inequalities, then of lower and upper bounds.
    label, unit : of the objective.
    """

    functions: Functions
    arguments: Callable[[SparseTask, object], Any]
    start: Floats
    names: tuple[str, ...]
    label: str
    unit: str
