"""Switching times of a bang-bang answer, as lengths of arcs of full torque.

On a grid a switch falls inside an interval, where the torque then stands between its limits, and
the time found is a little too long.  So the answer's torques are read as arcs between switches, and
the lengths of the arcs become the only unknowns: the least sum of them that reaches the target.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.multistart.minimize import minimize
from jaxatt.optimize.status import Status
from jaxatt.problems.time_optimal.derivatives import torques
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.problems.time_optimal.reorientation import ReorientationForm, reorientation
from jaxatt.problems.time_optimal.search import FreeTimeFound
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.free_body import step

_SATURATED = 0.98
_MOST_BETWEEN = 2
"""Intervals in which a torque may stand between its limits at one switch."""
_SUBSTEPS = 32
_TOLERANCE = 1e-9
_CHANGES = 1e-2
"""Relative change of the time beyond which the arcs are another manoeuvre."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """A bang-bang manoeuvre.

    lengths : (M,) [s].  levels : (M, b), scaled controls of each arc, all at their limits.
    torques : (M, n + m) [N m], of wheels and thrusters.
    switches : times [s] at which each wheel and thruster changes its torque.
    """

    lengths: Floats
    levels: Floats
    torques: Floats
    switches: tuple[Floats, ...]

    @property
    def final_time(self) -> float:
        """Sum of the arcs' lengths [s]."""
        return float(self.lengths.sum())


def resolve_switches(task: ReorientationTask, found: FreeTimeFound) -> Arcs | None:
    """Arcs of the best answer; None where it is not bang-bang, or where that fails."""
    best, form = found.best, task.form
    plain = form.body.attitude == "quaternion" and form.body.integration == "rk4"
    limited = form.cones or form.rate_limited or form.carries_impulses
    if not plain or limited or not found.reached[best] or found.step[best] == 0.0:
        return None
    lower, upper = task.actuation.lower, task.actuation.upper
    read = _read(found.scaled[best], float(found.step[best]), lower, upper)
    if read is None:
        return None
    lengths, levels = read
    reference = task.reference(-1.0 if found.long_way[best] else 1.0)
    parameters = replace(task.parameters, reference=jnp.asarray(reference))
    ended = minimize(
        _total,
        jnp.asarray(lengths),
        (parameters, jnp.asarray(levels)),
        equality=_missed_by(form, task.actuation.size),
        lower=0.0,
        tolerance=_TOLERANCE,
    )
    solved = np.asarray(ended.x)
    change = abs(solved.sum() / lengths.sum() - 1.0)
    if Status(int(ended.status)) != Status.CONVERGED or change > _CHANGES:
        return None
    torque = task.torques(levels)
    arcs = Arcs(solved, levels, torque, _switches(solved, torque))
    attitude, rate = flown_arcs_error(task, arcs)
    within = task.tolerances
    return arcs if attitude <= within["attitude"] and rate <= within["rate"] else None


def _total(lengths: Array, parameters: ReorientationParameters, levels: Array) -> Array:
    return jnp.sum(lengths)


@functools.cache
def _missed_by(form: ReorientationForm, size: int) -> Callable[..., Array]:
    """Function (lengths, parameters, levels) -> terminal errors (m,) after the arcs."""
    program, body = reorientation(form, size), replace(form.body, substeps=_SUBSTEPS)

    def missed(lengths: Array, p: ReorientationParameters, levels: Array) -> Array:
        def arc(
            state: tuple[Array, ...], one: tuple[Array, Array]
        ) -> tuple[tuple[Array, ...], None]:
            length, level = one
            return step(state, torques(p, level), length, p.body, body), None

        start = tuple(p.start[i] for i in range(body.size))
        end, _ = lax.scan(arc, start, (lengths, levels))
        x = jnp.stack((*end, jnp.zeros((), lengths.dtype)))
        return program.final_equalities(x, p)

    return missed


def _read(u: Floats, h: float, lower: Floats, upper: Floats) -> tuple[Floats, Floats] | None:
    """Lengths (M,) and levels (M, b) of the arcs of controls (N, b) held for h [s] each."""
    scaled = (2.0 * u - upper - lower) / (upper - lower)
    side = np.where(np.abs(scaled) >= _SATURATED, np.sign(scaled), 0.0)
    events: list[tuple[float, int]] = []
    first = np.zeros(u.shape[1])
    for j, (values, sides) in enumerate(zip(scaled.T, side.T, strict=True)):
        at_limit = np.flatnonzero(sides)
        if not len(at_limit):
            return None
        # What stands between the limits at either end belongs to a switch there.
        head, tail = at_limit[0], len(sides) - 1 - at_limit[-1]
        known = [(-1, -sides[at_limit[0]])] if head else []
        known += [(int(k), sides[k]) for k in at_limit]
        known += [(len(sides), -sides[at_limit[-1]])] if tail else []
        first[j] = known[0][1]
        for (before, was), (after, now) in itertools.pairwise(known):
            between = values[before + 1 : after]
            if len(between) > _MOST_BETWEEN or (was == now and len(between)):
                return None
            if was != now:
                events.append((h * (before + 1 + float(np.sum((between - now) / (was - now)))), j))
    events.sort()
    total = h * len(u)
    edges = np.array([0.0, *(time for time, _ in events), total])
    levels, now_at = [np.where(first > 0.0, upper, lower)], first.copy()
    for _, j in events:
        now_at[j] = -now_at[j]
        levels.append(np.where(now_at > 0.0, upper, lower))
    return np.maximum(np.diff(edges), 0.0), np.array(levels)


def _switches(lengths: Floats, torque: Floats) -> tuple[Floats, ...]:
    """Times [s] at which each torque (M, b) changes."""
    edges = np.cumsum(lengths)[:-1]
    return tuple(edges[np.abs(np.diff(values)) > 0.0] for values in torque.T)


def flown_arcs_error(task: ReorientationTask, arcs: Arcs, between: int = 64) -> tuple[float, float]:
    """Errors of attitude [rad] and rate [rad/s] after the arcs, flown on the full model.

    between : Runge-Kutta steps an arc.
    """
    state = task.start
    for length, torque in zip(arcs.lengths, arcs.torques, strict=True):
        state = task.fly_on(state, torque, float(length), between)
    q = np.asarray(state.q_ob)
    rate = np.linalg.norm(np.asarray(state.omega_ib) - task.target.facing(q).omega_ob)
    return task.angle_to_target(q), float(rate)
