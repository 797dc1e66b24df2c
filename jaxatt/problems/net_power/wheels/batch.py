"""Solve of all starts of one or more manoeuvres with wheels, in one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.interior_point.state import SMALL_SHIFTS, Shifts
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import OF_MANOEUVRE, WheelsParameters
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.starts import Starts
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.runtime.chunks import Report

_SHIFTS = Shifts(3e-4, 6.0, 4.0, 6e-6)
"""Where nothing but the wheels turns the body, curvature is missing seldom and soon there again."""

SETTINGS = InteriorSettings(
    tolerance=1e-6, barrier=1e-2, max_iterations=60, shifts=_SHIFTS, crossover_from=0.0
)
_MAGNITUDES = replace(SETTINGS, own_costates=True, max_iterations=70, settling=10)
"""Where power is a magnitude, rolls about the line to the sun cost nearly nothing, and steps along
them are long: constraints hold to a hundredth until they are held back."""

_TORQUED = replace(SETTINGS, shifts=SMALL_SHIFTS, own_costates=True, settling=10)
"""Over an orbit with its shadow, much of a manoeuvre earns the same whatever it does; what is left
to gain after so many passes is some ten joules of tens of thousands."""

_DECIDED = replace(_TORQUED, max_iterations=150, settling=15)
"""Dipoles that are decided act weakly and late: constraints at the end hold after more passes."""


def settings_for(form: WheelsForm) -> InteriorSettings:
    """Settings of the solver that suit a form."""
    if form.dipoles:
        return _DECIDED
    if form.torqued:
        return _TORQUED
    return _MAGNITUDES if form.powers else SETTINGS


@dataclass(frozen=True)
class WheelsJob:
    """Static part of a search, as `run_starts` needs it.

    own : whether each leaf of the parameters is there for every manoeuvre, along a leading axis,
        or once for all of them; empty for a single manoeuvre.
    """

    form: WheelsForm
    own: tuple[bool, ...]

    @property
    def label(self) -> str:
        """Label for `jaxatt.runtime.compilation`."""
        return f"net power, {self.own}, {self.form}"

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        return wheels_programme(self.form)

    def enter(
        self, start: Starts, parameters: WheelsParameters
    ) -> tuple[tuple[Array, Array], WheelsParameters]:
        """Initial controls and states for the solver, and the parameters of one start."""
        leaves, tree = jax.tree.flatten(parameters)
        if self.own:
            leaves = [
                jnp.asarray(leaf)[start.task] if own else leaf
                for leaf, own in zip(leaves, self.own, strict=True)
            ]
        own = replace(jax.tree.unflatten(tree, leaves), reference=jnp.asarray(start.reference))
        return (jnp.asarray(start.u), jnp.asarray(start.x)), own


def solve_starts(
    tasks: Sequence[WheelsTask],
    starts: Starts,
    settings: InteriorSettings | None = None,
    report: Report | None = None,
    rows: int | None = None,
    room: int = 1,
) -> InteriorSolution:
    """Solve from all starts of tasks that have one form, and gather the results on the host.

    rows : starts in one compiled call.  room : tasks that the call has room for, at least.
    """
    count, intervals = starts.u.shape[:2]
    parameters, own = _gathered([*tasks, *[tasks[0]] * (room - len(tasks))])
    # As many rows as all of them would have.
    count = count * max(len(tasks), room) // len(tasks)
    found: InteriorSolution = run_starts(
        InteriorPoint(settings or settings_for(tasks[0].form)),
        WheelsJob(tasks[0].form, own),
        starts,
        parameters,
        rows=rows or rows_of_stages(count, intervals),
        progress=None if report is None else lambda done: report("solving from all starts", done),
    )
    return found


def _gathered(tasks: Sequence[WheelsTask]) -> tuple[Any, tuple[bool, ...]]:
    """Parameters of all tasks, and which leaves of them each task has of its own.

    What all of them share is there once: a product with it costs a fraction of one with a matrix
    for every start.  What belongs to a manoeuvre is never shared, even where it happens to be the
    same, or the next manoeuvres would need another program.
    """
    if len(tasks) == 1:
        return tasks[0].parameters, ()
    every = [jax.tree.leaves_with_path(task.parameters) for task in tasks]
    leaves, own = [], []
    for (path, first), *others in zip(*every, strict=True):
        differs = path[0].name in OF_MANOEUVRE or any(
            not np.array_equal(first, other) for _, other in others
        )
        leaves.append(np.stack([first, *(leaf for _, leaf in others)]) if differs else first)
        own.append(differs)
    return jax.tree.unflatten(jax.tree.structure(tasks[0].parameters), leaves), tuple(own)
