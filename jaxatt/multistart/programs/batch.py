"""Solve a programme over stages from many starts at once by the interior-point method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.multistart.programs.starts import ProgramStarts
from jaxatt.optimize.interior_point.method import InteriorPoint, InteriorPointInTurn
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.lapack import calls_lapack
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.runtime.chunks import Progress, chunk_for

_MEMORY = 8e6
"""[bytes] Of a chunk's derivatives, so that they stay near the core."""
_COPIES = 10
"""Matrices of the size of a stage's Hessian that a stage has at a time."""
_LEAST, _MOST = 8, 32


@dataclass(frozen=True)
class PathStarts:
    """A programme whose starts are controls and states, as `run_starts` needs it."""

    program: OptimalControlProgram
    label: str | None = None

    def enter(self, start: ProgramStarts, args: Any) -> tuple[tuple[Array, Array], Any]:
        """Initial controls and states for the solver, and the arguments that all starts share."""
        return (jnp.asarray(start.u), jnp.asarray(start.x)), args


def _rows(program: OptimalControlProgram, starts: ProgramStarts) -> int:
    """Number of starts in one compiled call, small enough for the derivatives to stay in cache."""
    count, intervals, size = starts.u.shape
    rows = chunk_for(count)
    if jax.default_backend() != "cpu":
        return rows
    a_start = 8.0 * _COPIES * intervals * (program.error_size + size) ** 2
    fitting = 1 << max(0, int(np.log2(_MEMORY / a_start)))
    return min(rows, max(_LEAST, min(_MOST, fitting)))


def _in_turn(program: OptimalControlProgram, starts: ProgramStarts, args: Any) -> bool:
    """Whether the programme's own functions call LAPACK."""

    def everything(u: Array, x: Array, args: Any) -> Any:
        stage = jax.tree.map(lambda leaf: leaf[0], program.stages(args))
        return (
            program.start(args),
            program.next_and_cost(x, u, stage, args),
            program.equalities(x, u, stage, args),
            program.inequalities(x, u, stage, args),
            program.control_limits(stage, args),
            program.final_equalities(x, args),
            program.final_inequalities(x, args),
            program.final_cost(x, args),
            program.difference(program.retract(x, program.difference(x, x)), x),
        )

    u, x = jnp.asarray(starts.u[0, 0]), jnp.asarray(starts.x[0, 0])
    return calls_lapack(everything, u, x, args)


def solve_starts(
    program: OptimalControlProgram,
    starts: ProgramStarts,
    args: Any,
    settings: InteriorSettings,
    progress: Progress | None = None,
) -> InteriorSolution:
    """Solve from all starts and gather the results on the host, leading axis S."""
    solver = InteriorPointInTurn if _in_turn(program, starts, args) else InteriorPoint
    found: InteriorSolution = run_starts(
        solver(settings),
        PathStarts(program),
        starts,
        args,
        rows=_rows(program, starts),
        progress=progress,
    )
    return found
