"""Interface of a solver: `init`, `step`, `done` and `result` for one start.

A solver knows one start.  `solve` runs it to the end, here and under `jax.vmap`; the driver in
`jaxatt.multistart` runs many starts side by side.  What a solver does not support it refuses by
name, before anything is compiled.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from jax import Array, lax

_SOLVERS: list[type[Solver]] = []


class Solver(ABC):
    """A method that solves one kind of programme, from one start.

    Subclasses are frozen dataclasses registered as pytrees whose leaves are settings, so that
    another tolerance does not compile anew.  Nothing raises inside the four functions; a start
    ends in an honest status.

    name : what messages call it.  supports : features that it takes into account.
    needs : features that it cannot do without.
    same_passes : whether all starts take the same number of passes, so that none waits for another.
    calls_lapack : whether a pass calls LAPACK; such programs cannot run side by side, where they
        may wait for ever for each other's threads.
    batch_axis : where the axis of a batch is fastest inside, 0 or -1.
    passes : that many are made by a batch between two looks for starts that have ended.
    """

    name: ClassVar[str]
    supports: ClassVar[frozenset[str]]
    needs: ClassVar[frozenset[str]] = frozenset()
    same_passes: ClassVar[bool] = False
    calls_lapack: ClassVar[bool] = False
    batch_axis: ClassVar[int] = -1
    passes: ClassVar[int] = 4

    def __init_subclass__(cls) -> None:
        _SOLVERS.append(cls)

    @abstractmethod
    def init(self, program: Any, start: Any, args: Any) -> Any:
        """State before the first pass."""

    @abstractmethod
    def step(self, program: Any, state: Any, args: Any) -> Any:
        """State after one more pass."""

    @abstractmethod
    def done(self, state: Any) -> Array:
        """Whether a start has ended, ()."""

    @abstractmethod
    def result(self, program: Any, state: Any, args: Any) -> Any:
        """Result of a start that has ended."""


def solve(solver: Solver, program: Any, start: Any, args: Any) -> Any:
    """Run one start to its result; `jax.vmap` runs many."""
    refuse(solver, program)
    state = lax.while_loop(
        lambda state: ~solver.done(state),
        lambda state: solver.step(program, state, args),
        solver.init(program, start, args),
    )
    return solver.result(program, state, args)


def refuse(solver: Solver, program: Any) -> None:
    """Raise ValueError where a programme and a solver do not fit.

    It names each feature that the solver does not support, or that it needs and the programme
    lacks.
    """
    asked: frozenset[str] = program.features
    for feature in sorted(asked - solver.supports):
        able = sorted({other.name for other in _SOLVERS if feature in other.supports})
        remedy = f"choose {' or '.join(able)}" if able else "no solver does"
        raise ValueError(f"{feature}: {solver.name} does not support it; {remedy}")
    for feature in sorted(solver.needs - asked):
        raise ValueError(f"{feature}: {solver.name} needs it and the programme has none")
