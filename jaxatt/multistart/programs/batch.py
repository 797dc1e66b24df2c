"""Solve a programme over stages from many starts at once by the interior-point method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.multistart.programs.starts import ProgramStarts
from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.method import InteriorPoint, InteriorPointInTurn
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.lapack import calls_lapack
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.runtime.chunks import Progress


@dataclass(frozen=True)
class PathStarts:
    """A programme whose starts are controls and states, as `run_starts` needs it."""

    program: OptimalControlProgram
    label: str | None = None

    def enter(self, start: ProgramStarts, args: Any) -> tuple[tuple[Array, Array], Any]:
        """Initial controls and states for the solver, and the arguments that all starts share."""
        return (jnp.asarray(start.u), jnp.asarray(start.x)), args


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
        rows=rows_of_stages(*starts.u.shape[:2]),
        progress=progress,
    )
    return found
