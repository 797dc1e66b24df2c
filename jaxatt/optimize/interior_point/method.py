"""The interior-point method behind the interface of a solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.interior_point.newton_pass import advanced
from jaxatt.optimize.interior_point.solver import InteriorSolution, begin, outcome, running
from jaxatt.optimize.interior_point.state import InteriorSettings, Limits, State
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.solver import Solver


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class InteriorPoint(Solver):
    """Interior-point method for an `OptimalControlProgram`.

    A start is its controls (N, b) and states (N + 1, s), which need not obey the dynamics.
    """

    settings: InteriorSettings

    name = "interior point"
    supports = frozenset(
        {
            features.DYNAMICS,
            features.PATH_EQUALITY,
            features.PATH_INEQUALITY,
            features.TERMINAL_EQUALITY,
            features.TERMINAL_INEQUALITY,
            features.TERMINAL_COST,
            features.CONTROL_BOUNDS,
            features.FREE_INITIAL_STATE,
            features.MANIFOLD,
        }
    )
    needs = frozenset({features.DYNAMICS})

    def init(self, program: OptimalControlProgram, start: tuple[Array, Array], args: Any) -> State:
        """State of a start, pushed off the limits."""
        return begin(program, *start, args, self.settings)

    def step(self, program: OptimalControlProgram, state: State, args: Any) -> State:
        """Take a Newton step of the barrier problem, or of the crossover."""
        limits = Limits.of(program, state.place.point.nodes.u.shape[1], args)
        return advanced(program, limits, state, args, self.settings)

    def done(self, state: State) -> Array:
        """Whether the start has ended or run out of passes."""
        return ~running(state, self.settings)

    def result(self, program: OptimalControlProgram, state: State, args: Any) -> InteriorSolution:
        """Result of a start from its final state."""
        return outcome(state, self.settings)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class InteriorPointInTurn(InteriorPoint):
    """The same for programmes whose functions call LAPACK: one chunk of starts at a time."""

    calls_lapack = True
