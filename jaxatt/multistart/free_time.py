"""Multi-start search for the best reorientation in free time: Algorithm A, all starts at once.

1. Every start is a random feasible path (`random_paths`).
2. All of them are solved at once by the interior-point method; slow ones are retired and solved
   among themselves.
3. Every answer is flown again with fine steps; the cheapest that reaches is the answer.

Source: Sensors and Materials 32 (5), 2020, 1671 ff., section 5.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from jaxatt.multistart.random_paths import Paths, random_paths
from jaxatt.multistart.retiring import retiring
from jaxatt.optimize.interior_point import InteriorSettings, InteriorSolution, solve_interior
from jaxatt.optimize.status import Status
from jaxatt.problems.reorientation import (
    ReorientationForm,
    ReorientationParameters,
    reorientation,
)
from jaxatt.problems.reorientation_task import ReorientationTask
from jaxatt.problems.task import Floats, Verdict
from jaxatt.simulation.chunks import chunk_for

Report = Callable[[str, int], None]
"""(stage, starts that have just ended), called by the host between chunks."""

_EARLY_ITERATIONS = 32
_SAME = 1e-4
"""Relative difference of costs up to which two answers are one minimum."""
_MOST_TIGHTENINGS = 4
_TIGHTER = 1.2


@dataclass(frozen=True, eq=False)
class FreeTimeFound:
    """Outcome of a search; leading axis S.

    controls : (S, N, n + m) [N m], torques of wheels and thrusters.  step : (S,) [s].
    cost : (S,) [s].  status : (S,) `Status`.  violation, stationarity : (S,), as the solver has
    them.  iterations : (S,).  own_error : (S,) [rad], by which the transcription's own end misses.
    long_way : (S,).  verdict : of flights with fine steps.
    best : index of the answer.  minima : distinct ones among the starts that converged.
    share : of all starts, those that ended at the best.
    """

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
    best: int
    minima: int
    share: float

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """(S,), by re-simulation."""
        return self.verdict.reached


def _placed(lane: Paths, arguments: ReorientationParameters) -> ReorientationParameters:
    return replace(arguments, step=lane.step, reference=lane.reference)


@functools.partial(jax.jit, static_argnames=("form", "size"))
def _solve_chunk(
    form: ReorientationForm,
    size: int,
    lanes: Paths,
    arguments: ReorientationParameters,
    settings: InteriorSettings,
) -> InteriorSolution:
    program = reorientation(form, size)

    def one(lane: Paths) -> InteriorSolution:
        return solve_interior(program, lane.u, lane.states, _placed(lane, arguments), settings)

    # The batch axis goes last, where every component becomes one contiguous vector.
    last = jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, -1), lanes)
    found = jax.vmap(one, in_axes=-1, out_axes=-1)(last)
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), found)


def solve_paths(
    task: ReorientationTask,
    paths: Paths,
    settings: InteriorSettings | None = None,
    arguments: ReorientationParameters | None = None,
    report: Report | None = None,
) -> InteriorSolution:
    """Solve a task from all of its starts, chunk by chunk, and gather the results on the host.

    arguments : in place of the task's own; leaves that differ from start to start are not allowed.
    """
    settings = settings or InteriorSettings()
    arguments = arguments or task.parameters
    run = functools.partial(_solve_chunk, task.form, task.actuation.size)
    progress = None if report is None else lambda done: report("solving from all starts", done)
    return retiring(
        lambda chunk, limited: run(chunk, arguments, limited),
        paths,
        settings,
        chunk_for(len(paths.u)),
        progress,
        ("reorientation", task.form, paths.u.shape[1:]),
        early=_EARLY_ITERATIONS,
    )


def search_free_time(
    task: ReorientationTask, count: int, seed: int, report: Report | None = None
) -> FreeTimeFound:
    """Find the best reorientation of a task from `count` starts."""
    if task.at_target:
        return _nothing_to_do(task)
    paths = random_paths(task, count, seed)
    solution = solve_paths(task, paths, report=report)
    found = evaluate(task, paths, solution)
    return _between_nodes(task, paths, found, report)


def evaluate(task: ReorientationTask, paths: Paths, solution: InteriorSolution) -> FreeTimeFound:
    """Fly every answer again and choose the best."""
    finite = np.isfinite(solution.u).all(axis=(1, 2)) & np.isfinite(solution.x).all(axis=(1, 2))
    torque = task.torques(np.nan_to_num(solution.u))
    step = np.where(finite, np.exp(np.where(finite, solution.x[:, -1, -1], 0.0)), np.nan)
    flown = task.fly(torque, np.nan_to_num(step), between=_between(task))
    verdict = task.judge(flown, torque)
    status = np.where(finite, solution.status, int(Status.NOT_FINITE))
    cost = task.cost(torque, step)
    best, minima, share = _ranked(cost, status, verdict)
    rows = jax.vmap(task.program.final_rows, in_axes=(0, None))(
        jnp.asarray(np.nan_to_num(solution.x[:, -1])), task.parameters
    )
    turned = np.asarray(rows)[:, :3]
    other = np.linalg.norm(paths.reference - task.reference(1.0), axis=1) > _SAME
    return FreeTimeFound(
        torque,
        step,
        cost,
        status,
        solution.violation,
        solution.stationarity,
        solution.iterations,
        np.where(other, solution.violation, np.linalg.norm(turned, axis=1)),
        other,
        verdict,
        best,
        minima,
        share,
    )


def _between(task: ReorientationTask) -> int:
    """Nodes an interval at which a flight is judged: many where the path is limited."""
    form = task.form
    return 20 if form.cones or form.rate_limited or form.speed_limited else 1


def _ranked(cost: Floats, status: Floats, verdict: Verdict) -> tuple[int, int, float]:
    """Index of the answer, number of minima, share of the starts at the best."""
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
    """Tighten cones that the best answers cut between two nodes, and solve again."""
    limits = task.pointing.limits
    backed = np.zeros(limits.count)
    for _ in range(_MOST_TIGHTENINGS if limits.count else 0):
        ended = np.flatnonzero(found.status == Status.CONVERGED)
        if not len(ended):
            return found
        index = ended[np.argmin(found.cost[ended])]
        if found.verdict.reached[index]:
            return found
        torque, step = found.controls[index : index + 1], found.step[index : index + 1]
        flown = task.fly(torque, step, between=_between(task))
        over = task.cone_excess(np.asarray(flown.q_ob))[0].max(axis=0)
        if (over <= Verdict.MARGIN_TOLERANCE).all():
            return found
        backed = backed + _TIGHTER * np.maximum(over, 0.0)
        angle = np.arccos(np.asarray(limits.cosines)) - np.asarray(limits.senses) * backed
        tightened = replace(
            task.parameters,
            limits=replace(task.parameters.limits, cosines=jnp.asarray(np.cos(angle))),
        )
        found = evaluate(task, paths, solve_paths(task, paths, None, tightened, report))
    return found


def _nothing_to_do(task: ReorientationTask) -> FreeTimeFound:
    """The answer where the start is the target: no time, no torque."""
    torque = np.zeros((1, task.intervals, task.craft.actuators))
    nothing = np.zeros(1)
    verdict = task.judge(task.fly(torque, nothing), torque)
    status = np.array([int(Status.CONVERGED)])
    flags = np.zeros(1, bool)
    return FreeTimeFound(
        torque,
        nothing,
        nothing,
        status,
        nothing,
        nothing,
        np.zeros(1, int),
        nothing,
        flags,
        verdict,
        0,
        1,
        1.0,
    )
