"""Entry of a start into the programme of a reorientation, and the solve of all starts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import jax.numpy as jnp
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.reorientation import ReorientationForm, reorientation
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.chunks import Report


@dataclass(frozen=True)
class PathForm:
    """Static part of a reorientation, as `run_starts` needs it.

    size : number of controls.
    """

    form: ReorientationForm
    size: int
    label: str | None = None

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        return reorientation(self.form, self.size)

    def enter(
        self, path: Paths, parameters: ReorientationParameters
    ) -> tuple[tuple[Array, Array], ReorientationParameters]:
        """Initial controls and states for the solver, and the parameters of one start."""
        own = replace(
            parameters,
            step=jnp.asarray(path.step),
            reference=jnp.asarray(path.reference),
            effort_weight=jnp.asarray(path.effort_weight),
        )
        return (jnp.asarray(path.u), jnp.asarray(path.states)), own


def solve_paths(
    task: ReorientationTask,
    paths: Paths,
    settings: InteriorSettings | None = None,
    arguments: ReorientationParameters | None = None,
    report: Report | None = None,
    rows: int | None = None,
) -> InteriorSolution:
    """Solve a task from all of its starts and gather the results on the host.

    arguments : in place of the task's own.  rows : starts in one compiled call.
    """
    progress = None if report is None else lambda done: report("solving from all starts", done)
    found: InteriorSolution = run_starts(
        InteriorPoint(settings or InteriorSettings()),
        PathForm(task.form, task.actuation.size),
        paths,
        arguments or task.parameters,
        rows=rows or rows_of_stages(*paths.u.shape[:2]),
        progress=progress,
    )
    return found
