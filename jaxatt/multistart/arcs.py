"""Switching times of a bang-bang answer: arcs of full torque whose lengths are solved for.

On a grid a switch falls inside an interval, where the torque then stands between its limits, and
the time found is a little too long.  So the answer's torques are read as arcs between switches, and
the lengths of the arcs become the only unknowns: the least sum of them that reaches the target.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.minimization import minimize
from jaxatt.multistart.free_time import FreeTimeFound
from jaxatt.optimize.status import Status
from jaxatt.problems.reorientation import ReorientationParameters
from jaxatt.problems.reorientation_derivatives import torques
from jaxatt.problems.reorientation_task import ReorientationTask
from jaxatt.problems.task import Floats
from jaxatt.simulation.free_body import step

_SATURATED = 0.98
_SUBSTEPS = 24
_TOLERANCE = 1e-9
_FALLS = 1e-2
"""Relative change of the time beyond which the arcs are another manoeuvre, not this one."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """A bang-bang manoeuvre.

    lengths : (M,) [s].  levels : (M, b), scaled controls of each arc, at their limits.
    final_time : [s].  switches : times [s] at which each actuator changes.
    """

    lengths: Floats
    levels: Floats
    final_time: float
    switches: tuple[Floats, ...]


def resolve_switches(task: ReorientationTask, found: FreeTimeFound) -> Arcs | None:
    """Arcs of the best answer; None where it is not bang-bang, or they lead nowhere."""
    best = found.best
    if not found.reached[best] or found.step[best] == 0.0 or task.form.cones or task.form.speed_limited:
        return None
    u = _scaled(task, found.controls[best])
    read = _read(u, float(found.step[best]), task.actuation.lower, task.actuation.upper)
    if read is None:
        return None
    lengths, levels = read
    problem = _problem(task.program.final_rows, task)
    sign = -1.0 if found.long_way[best] else 1.0
    parameters = jax.tree.map(jnp.asarray, task.parameters)
    ended = minimize(
        lambda d, p, v: jnp.sum(d),
        jnp.asarray(lengths),
        (parameters, jnp.asarray(levels)),
        equality=problem,
        lower=0.0,
        tolerance=_TOLERANCE,
    )
    total = float(np.sum(np.asarray(ended.x)))
    near = abs(total / lengths.sum() - 1.0) < _FALLS
    if Status(int(ended.status)) != Status.CONVERGED or not near:
        return None
    del sign
    return Arcs(np.asarray(ended.x), levels, total, _switches(task, np.asarray(ended.x), levels))
