"""Multi-start search for the best reorientation in free time (Algorithm A of the source).

1. Every start is a random path, feasible from rest (`random_paths`) or in motion (`moving_paths`).
2. All of them are solved at once by the interior-point method; those that end make room for others.
3. Every answer is flown again with fine steps; the cheapest that reaches is the answer.

Source: Sensors and Materials 32 (5), 2020, 1671 ff., section 5.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.interior_point.solver import InteriorSolution
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.status import Status
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.starts import starts_of
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import overstay, speed_excess, speed_range
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_SAME = 1e-4
"""Relative difference of costs up to which two answers are one minimum."""
_MOST_REFINEMENTS = 2
_MET = 1e-6
"""Violation of the programme up to which what a flight misses is the error of its steps."""
_STATIONARY = 1e-4
"""Scaled stationarity of an answer whose derivatives are used, if the solver's own is not met."""
_LEFT = 0.1
"""Of the tolerances, what more steps are to leave of that error."""
_MOST_MORE = 8.0
_ORDER = 4
_MOST_TIGHTENINGS = 4
_TIGHTER = 1.2


@dataclass(frozen=True, eq=False)
class FreeTimeFound:
    """Outcome of a search; leading axis S.

    scaled : (S, N, b) controls and states : (S, N + 1, s), of the solver.
    controls : (S, N, n + m) [N m], torques of wheels and thrusters.  step : (S,) [s].
    cost : (S,) [s].  status : (S,) `Status`.  violation, stationarity : (S,), as the solver has
    them.  iterations : (S,).  own_error : (S,) [rad], by which the transcription's own end misses.
    long_way : (S,).  verdict : of flights with fine steps.
    rows, limits : multipliers of the solver, of the terminal rows and of all limits.
    constraint_margin : (m + 1,), how much stricter cones [rad] and rates were taken than they are.
    substeps : Runge-Kutta steps an interval of the solver.
    best : index of the answer.  minima : distinct ones among the starts that converged.
    share : of all starts, those that ended at the best.
    """

    scaled: Floats
    states: Floats
    controls: Floats
    step: Floats
    cost: Floats
    status: npt.NDArray[np.int64]
    violation: Floats
    stationarity: Floats
    iterations: npt.NDArray[np.int64]
    own_error: Floats
    long_way: npt.NDArray[np.bool_]
    verdict: Verdict
    substeps: int
    best: int
    minima: int
    share: float
    constraint_margin: Floats
    rows: Floats
    limits: Bounded

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """Whether the flight of each start reached the target, (S,)."""
        return self.verdict.reached

    @property
    def answered(self) -> bool:
        """Whether the best meets its constraints and is stationary, to what a derivative needs."""
        met, rest = self.violation[self.best], self.stationarity[self.best]
        return bool(np.isfinite(self.cost[self.best]) and met <= _MET and rest <= _STATIONARY)


def search_free_time(
    task: ReorientationTask, count: int, seed: int, report: Report | None = None
) -> FreeTimeFound:
    """Find the best reorientation of a task from `count` starts."""
    if task.at_target:
        return _nothing_to_do(task)
    paths = starts_of(task, count, seed)
    found = evaluate(task, paths, solve_paths(task, paths, report=report))
    for _ in range(_MOST_REFINEMENTS if task.measures_substeps else 0):
        substeps = _substeps_asked(task, found)
        if substeps is None:
            break
        task = task.with_substeps(substeps)
        found = evaluate(task, paths, solve_paths(task, paths, report=report))
    return _between_nodes(task, paths, found, report)


@functools.partial(jax.jit, static_argnums=0)
def _final_rows(program: OptimalControlProgram, x: Array, parameters: Any) -> Array:
    return jax.vmap(program.final_equalities, in_axes=(0, None))(x, parameters)


def _substeps_asked(task: ReorientationTask, found: FreeTimeFound) -> int | None:
    """Steps an interval that the best answer needs, where its flight misses for want of them."""
    met = np.flatnonzero((found.violation <= _MET) & np.isfinite(found.cost))
    if not len(met):
        return None
    missed = float(found.verdict.shortfall[met[np.argmin(found.cost[met])]])
    if missed <= 1.0:
        return None
    more = min(_MOST_MORE, (missed / _LEFT) ** (1.0 / _ORDER))
    return math.ceil(more * task.form.body.substeps)


def evaluate(task: ReorientationTask, paths: Paths, solution: InteriorSolution) -> FreeTimeFound:
    """Fly every answer again and choose the best."""
    finite = np.isfinite(solution.u).all(axis=(1, 2)) & np.isfinite(solution.x).all(axis=(1, 2))
    torque = task.torques(np.nan_to_num(solution.u))
    step = np.where(finite, np.exp(np.where(finite, solution.x[:, -1, -1], 0.0)), np.nan)
    flown = task.fly(torque, np.nan_to_num(step))
    verdict = task.judge(flown, torque, np.nan_to_num(step))
    status = np.where(finite, solution.status, int(Status.NOT_FINITE))
    cost = task.cost(torque, step)
    best, minima, share = _ranked(cost, status, verdict)
    ends = jnp.asarray(np.nan_to_num(solution.x[:, -1]))
    held = len(task.target.held)
    turned = np.asarray(_final_rows(task.program, ends, task.parameters))[:, :held]
    other = np.linalg.norm(paths.reference - task.reference(1.0), axis=1) > _SAME
    return FreeTimeFound(
        np.nan_to_num(solution.u),
        np.nan_to_num(solution.x),
        torque,
        step,
        cost,
        status,
        np.asarray(solution.violation),
        np.asarray(solution.stationarity),
        np.asarray(solution.iterations),
        np.where(other, solution.violation, np.linalg.norm(turned, axis=1)),
        other,
        verdict,
        task.form.body.substeps,
        best,
        minima,
        share,
        np.zeros(len(task.pointing.cones) + 1),
        np.asarray(solution.rows),
        solution.dual,
    )


def _ranked(cost: Floats, status: Floats, verdict: Verdict) -> tuple[int, int, float]:
    """Index of the answer, number of minima, and share of the starts at the best."""
    usable = np.where(np.isfinite(cost), cost, np.inf)
    missed = np.where(verdict.reached, 0.0, np.maximum(1.0, verdict.shortfall))
    best = int(np.lexsort((usable, missed))[0])
    ended = np.sort(usable[(status == Status.CONVERGED) & np.isfinite(usable)])
    minima = int(len(ended) > 0) + int((np.diff(ended) > _SAME * np.abs(ended[1:])).sum())
    near = verdict.reached & (usable <= usable[best] * (1.0 + _SAME))
    return best, minima, float(near.mean())


def _between_nodes(
    task: ReorientationTask, paths: Paths, found: FreeTimeFound, report: Report | None
) -> FreeTimeFound:
    """Tighten limits on the way that the best answer violates between nodes; solve again.

    Bands of speed that a wheel may cross are barred where it does not leave them in time.
    """
    wheels, crossing = task.craft.wheels, None
    slower, weaker = np.zeros(wheels.count), np.zeros(wheels.count)
    for _ in range(_MOST_TIGHTENINGS if task.watches else 0):
        ended = np.flatnonzero(found.status == Status.CONVERGED)
        if not len(ended):
            return found
        index = int(ended[np.argmin(found.cost[ended])])
        torque, step = found.controls[index : index + 1], found.step[index : index + 1]
        flown = task.fly(torque, step)
        excess = task.watch(flown).excess[0]
        over = speed_excess(wheels, flown.omega_bw, crossing is not None)[0]
        n = wheels.count
        strained = motor_excess(wheels, torque[..., :n], flown.omega_bw)[0]
        late = overstay(wheels, flown.omega_bw, task.between_nodes(step))[0] > 0.0
        beyond = max(part.max(initial=0.0) for part in (excess, over, strained))
        if crossing is None and late:
            crossing = found
        elif found.verdict.reached[index] or not beyond > 0.0:
            break
        constraint_margin = found.constraint_margin + _TIGHTER * np.maximum(excess, 0.0)
        slower = slower + _TIGHTER * np.maximum(over, 0.0)
        weaker = weaker + _TIGHTER * np.maximum(strained, 0.0)
        begins = task.initial_state.omega_bw
        slowest, fastest = speed_range(wheels, begins, slower, crossing is not None)
        stricter = replace(
            task.parameters,
            limits=task.limits(constraint_margin),
            speed_lower=jnp.asarray(slowest),
            speed_upper=jnp.asarray(fastest),
            motor_limit=jnp.asarray(1.0 - weaker),
        )
        again = evaluate(task, paths, solve_paths(task, paths, None, stricter, report))
        found = replace(again, constraint_margin=constraint_margin)
    return found if crossing is None or found.reached[found.best] else crossing


def _nothing_to_do(task: ReorientationTask) -> FreeTimeFound:
    """The answer where the start is the target: no time, no torque."""
    scaled = np.zeros((1, task.intervals, task.actuation.size))
    torque, nothing = task.torques(scaled), np.zeros(1)
    verdict = task.judge(task.fly(torque, nothing), torque, nothing)
    return FreeTimeFound(
        scaled=scaled,
        states=starts_of(task, 1, 0).states,
        controls=torque,
        step=nothing,
        cost=nothing,
        status=np.array([int(Status.CONVERGED)]),
        violation=nothing,
        stationarity=nothing,
        iterations=np.zeros(1, int),
        own_error=nothing,
        long_way=np.zeros(1, bool),
        verdict=verdict,
        substeps=task.form.body.substeps,
        best=0,
        minima=1,
        share=1.0,
        constraint_margin=np.zeros(len(task.pointing.cones) + 1),
        rows=np.zeros((1, 0)),
        limits=Bounded(*(jnp.zeros((1, 0)) for _ in Bounded._fields)),
    )
