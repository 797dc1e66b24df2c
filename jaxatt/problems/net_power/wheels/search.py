"""Many starts of one or more manoeuvres with wheels, solved at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.interior_point.state import SMALL_SHIFTS
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.starts import Starts
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.runtime.chunks import Report, chunk_for

SETTINGS = InteriorSettings(
    tolerance=1e-6, barrier=1e-2, max_iterations=150, shifts=SMALL_SHIFTS, crossover_from=0.0
)


@dataclass(frozen=True)
class WheelsJob:
    """Static part of a search, as `run_starts` needs it.

    several : whether the parameters of every manoeuvre stand along a leading axis.
    """

    form: WheelsForm
    several: bool
    label: str | None = None

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        return wheels_programme(self.form)

    def enter(
        self, start: Starts, parameters: WheelsParameters
    ) -> tuple[tuple[Array, Array], WheelsParameters]:
        """Initial controls and states for the solver, and the parameters of one start."""
        own = parameters
        if self.several:
            own = jax.tree.map(lambda leaf: jnp.asarray(leaf)[start.task], parameters)
        own = replace(own, reference=jnp.asarray(start.reference))
        return (jnp.asarray(start.u), jnp.asarray(start.x)), own


def solve_starts(
    tasks: Sequence[WheelsTask],
    starts: Starts,
    settings: InteriorSettings = SETTINGS,
    report: Report | None = None,
    rows: int | None = None,
) -> InteriorSolution:
    """Solve from all starts of tasks that have one form, and gather the results on the host."""
    several = len(tasks) > 1
    parameters: Any = tasks[0].parameters
    if several:
        parameters = jax.tree.map(lambda *leaves: np.stack(leaves), *(t.parameters for t in tasks))
    found: InteriorSolution = run_starts(
        InteriorPoint(settings),
        WheelsJob(tasks[0].form, several),
        starts,
        parameters,
        rows=rows or chunk_for(len(starts.u)),
        progress=None if report is None else lambda done: report("solving from all starts", done),
    )
    return found


def search_wheels(manoeuvres, count, seed, report=None):  # temporary
    out = []
    from jaxatt.problems.net_power.found import Solved
    from jaxatt.problems.net_power.wheels.starts import draw_starts
    from jaxatt.problems.net_power.wheels.task import wheels_task

    for manoeuvre in manoeuvres:
        task = wheels_task(manoeuvre)
        starts = draw_starts(task, count, seed)
        r = solve_starts([task], starts, report=report)
        scale = float(task.parameters.energy_scale)
        n = task.form.wheels
        torque = np.asarray(r.u)[..., :n] * np.asarray(task.parameters.torque_limit)
        out.append(
            Solved(
                torque,
                None,
                -np.asarray(r.objective) * scale,
                np.asarray(r.status),
                np.asarray(r.violation),
                np.asarray(r.stationarity),
                np.asarray(r.iterations),
            )
        )
    return tuple(out)
