"""Decide supports from starts, and minimise the effort on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.least_effort.primal_dual import LeastEffort
from jaxatt.optimize.reweighting.condensed import CondensedReweighting
from jaxatt.optimize.reweighting.staged import StagedReweighting
from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.reweighting.weights import (
    SUPPORT_THRESHOLD,
    Gradual,
    Reweighting,
    SparseRoot,
)
from jaxatt.optimize.riccati.lagrangian import RiccatiLagrangian
from jaxatt.optimize.solver import Solver
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.batch import Form, Lanes, broadcast_lanes
from jaxatt.problems.hands_off.search.bounded_batch import DECIDE, DECIDE_SLOWLY, polish_bounded
from jaxatt.problems.hands_off.search.bounded_batch import SETTLE as SETTLE_BETWEEN
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate, join
from jaxatt.problems.hands_off.search.shared_lengths import (
    lengthened,
    lengthening,
    shortened,
)
from jaxatt.problems.hands_off.search.starts import Starts
from jaxatt.problems.hands_off.sparse_program import DecidedBy, SparseArguments
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import CHUNK, Progress

HOMOTOPY = Schedule(
    smoothing_start=0.1,
    smoothing_end=1e-4,
    smoothing_factor=0.587,
    max_inner=1,
    max_iterations=14,
    update_multipliers=0.0,
)
"""Reweighting: one Newton step a smoothing, constraints as penalties."""

POLISH = Schedule(
    stage_penalty=1e3, smoothing_start=0.03, smoothing_end=1e-4, max_inner=4, max_iterations=60
)
"""Least effort on a frozen support, to the full tolerance."""

STAGED = replace(POLISH, penalty=1e2)
"""The same stage by stage: along heavy rows, what they leave free (a roll) moves in tiny steps."""

LEAST = Schedule(smoothing_start=0.1, smoothing_factor=0.45, max_iterations=60)
"""The same by the primal-dual method."""

SCREENING = 30
"""Iterations after which a support that is only tried is given up."""

SLACK = Schedule(
    penalty=1e3, smoothing_start=3.0, smoothing_end=1e-2, max_inner=15, max_iterations=300
)
"""The L1 problem with slacks, whose objective is linear: more inner steps, a softer start."""

SETTLE = Reweighting(deciding=0, settling=8)
"""Least effort on a given support to the accuracy of the Newton steps, to see if it leads there."""

SETTLE_ROLL = 24
"""Steps of the same where the effort has a roll to settle, too."""

FOLLOW = Reweighting(deciding=200, smoothing=0.1, factor=0.965, settling=20, gradual=Gradual())
"""Deciding from starts in motion, which nearly lead to the target."""

SETTLED = 1e-5
"""[rad] Rows left before the last step up to which a settled start counts as feasible."""


@dataclass(frozen=True)
class Method:
    """Choice of solvers for a task.

    decides : "l0" or "l1", what decides the support.
    inner : name of the inner minimiser of the augmented Lagrangian; "riccati" takes the problem
        stage by stage, where its support is decided by counting.
    reweights : whether supports are decided and screened by reweighted Newton steps, where the
        task's system allows it, instead of by the augmented Lagrangian.
    rows : starts in one compiled call.  progress : called with the number of starts just ended.
    """

    decides: str
    inner: str = "gauss-newton"
    reweights: bool = True
    rows: int = CHUNK
    progress: Progress | None = None

    def run(
        self, task: SparseTask, solver: Solver, kind: str, lanes: Lanes, arguments: SparseArguments
    ) -> Any:
        """Run a solver from all lanes; kind : of the programme, see `Form`."""
        form = Form(task.system, task.shared, kind, task.size)
        more = lengthening(task, kind)
        lanes, arguments = lengthened(task.system, lanes._replace(aim=task.aims), arguments, more)
        found = run_starts(solver, form, lanes, arguments, rows=self.rows, progress=self.progress)
        return shortened(found, task.intervals) if more else found

    def lagrangian(self, schedule: Schedule) -> AugmentedLagrangian:
        """The augmented Lagrangian without stages, with the inner minimiser of this method."""
        inner = "gauss-newton" if self.inner == "riccati" else self.inner
        return AugmentedLagrangian(schedule, inner)

    def stages_for(self, task: SparseTask) -> bool:
        """Whether Riccati steps are taken: by choice, or because of path constraints."""
        if self.decides != "l0" or task.system.stages is None:
            return False
        own = task.system.decided_by is DecidedBy.STAGES
        return self.inner == "riccati" or (self.reweights and own)

    def reweights_for(self, task: SparseTask) -> bool:
        """Whether supports are decided by reweighting."""
        way = task.system.decided_by
        condensed = self.reweights and self.decides == "l0" and way is DecidedBy.CONDENSED
        return condensed or way is DecidedBy.BOUNDS or self.stages_for(task)

    def follows(self, task: SparseTask) -> bool:
        """Whether supports are decided gradually, from starts in motion."""
        return task.in_motion and self.reweights_for(task) and not self.stages_for(task)

    def deciding(self, task: SparseTask) -> Reweighting:
        """Settings with which supports are decided."""
        return FOLLOW if self.follows(task) else Reweighting()

    def settling(self, task: SparseTask) -> Reweighting:
        """Settings with which a given support is tried, of the same program as `deciding`."""
        steps = SETTLE_ROLL if task.leaves_roll_free else SETTLE.settling
        return replace(SETTLE, settling=steps, gradual=self.deciding(task).gradual)

    def spends_least_for(self, task: SparseTask) -> bool:
        """Whether supports are polished by the primal-dual method.

        The printed cost may rest where its rows do not vanish, which asks for a line search.
        """
        condensed = self.reweights_for(task) and not self.stages_for(task)
        bounded = task.system.decided_by is DecidedBy.BOUNDS
        return condensed and not bounded and task.goal.terminal == "reach"


def count_arguments(task: SparseTask) -> SparseArguments:
    """Arguments with which the number of active intervals is minimised."""
    return replace(task.arguments, count_scale=jnp.asarray(task.sparsity_weight))


def effort_arguments(task: SparseTask) -> SparseArguments:
    """Arguments with which the L1 effort is minimised."""
    scale = task.effort_weight if task.goal.terminal == "penalty" else 1.0
    return replace(task.arguments, count_scale=jnp.asarray(0.0), effort_scale=jnp.asarray(scale))


def _free(task: SparseTask, support: Mask) -> Floats:
    """Free variables of a support (..., N, g), without forbidden ones."""
    full = np.broadcast_to(support, (*support.shape[:-1], task.size))
    return full * np.asarray(task.arguments.free)


def reweighting(task: SparseTask, method: Method, settings: Reweighting) -> tuple[Solver, str]:
    """Choose the reweighting for a task, and the kind of its programme.

    By pulses, stage by stage, or between bounds.

    settings : where there are bounds, only whether the support is decided or given is read from it.
    """
    if task.system.decided_by is DecidedBy.BOUNDS:
        decides = DECIDE if task.system.path is None else DECIDE_SLOWLY
        return (decides if settings.deciding else SETTLE_BETWEEN), "roots"
    if method.stages_for(task):
        return StagedReweighting(settings), "stage roots"
    return CondensedReweighting(settings), "roots"


def reweight(task: SparseTask, lanes: Lanes, method: Method, settings: Reweighting) -> SparseRoot:
    """Take reweighted steps for all lanes."""
    solver, kind = reweighting(task, method, settings)
    found: SparseRoot = method.run(task, solver, kind, lanes, count_arguments(task))
    return found


def decide(task: SparseTask, starts: Starts, method: Method) -> tuple[Floats, Mask]:
    """Scaled controls and support of every start."""
    count = len(starts.u)
    free = np.broadcast_to(np.asarray(task.arguments.free), starts.u.shape)
    weight = np.asarray(task.arguments.weight)
    if weight.min() < weight.max():
        cheap = (weight < weight.max())[None, :, None]
        free = np.where(starts.confined[:, None, None], free * cheap, free)
    rows = np.broadcast_to(np.asarray(task.arguments.row_weight), (count, task.rows)).copy()
    rows[::2] = np.inf  # the printed cost may prefer standing still: half the starts must arrive
    if task.system.decided_by is DecidedBy.BOUNDS and method.decides == "l1":
        return starts.u * free, np.any(free > 0.0, axis=-1, keepdims=True)
    lanes = broadcast_lanes(starts.u * free, free, rows, starts.sign)
    if method.reweights_for(task):
        found = reweight(task, lanes, method, method.deciding(task))
        u = np.nan_to_num(np.asarray(found.u))
        active: Mask = np.asarray(found.support) > 0
        return u, np.any(active, axis=-1, keepdims=True) if task.shared else active
    if method.decides == "l1":
        solver, kind, arguments = method.lagrangian(SLACK), "slacks", effort_arguments(task)
    else:
        solver, kind, arguments = method.lagrangian(HOMOTOPY), "sparse", count_arguments(task)
    solution = method.run(task, solver, kind, lanes, arguments)
    u = np.nan_to_num(solution.x[..., : task.size])
    size = np.abs(u).max(axis=-1, keepdims=True) if task.shared else np.abs(u)
    return u, size > SUPPORT_THRESHOLD


def screen(task: SparseTask, u: Floats, supports: Mask, sign: Floats, method: Method) -> Candidates:
    """As `polish` with few iterations, to discard poor neighbours of a support early."""
    if not method.reweights_for(task):
        return polish(task, u, supports, sign, method, SCREENING)
    free = _free(task, supports)
    lanes = broadcast_lanes(u * free, free, task.arguments.row_weight, sign)
    found = reweight(task, lanes, method, method.settling(task))
    arrived = np.asarray(found.residual) <= SETTLED
    status = np.where(arrived, int(Status.FEASIBLE), int(Status.ITERATION_LIMIT))
    steps = np.full(len(u), method.settling(task).settling)
    settled = evaluate(task, np.asarray(found.u), status, steps, sign)
    stuck = np.flatnonzero(~arrived & np.asarray(found.saturated))
    if not len(stuck):
        return settled
    # Limits that bind nearly everywhere are beyond these Newton steps, not beyond the polish.
    again = polish(task.pick(stuck), u[stuck], supports[stuck], sign[stuck], method, SCREENING)
    kept = np.setdiff1d(np.arange(len(u)), stuck)
    return join(settled.pick(kept), again).pick(np.argsort(np.concatenate([kept, stuck])))


def polish(
    task: SparseTask,
    u: Floats,
    supports: Mask,
    sign: Floats,
    method: Method,
    most: int | None = None,
) -> Candidates:
    """Minimise the effort on supports (S, N, g), from u (S, N, b), and fly the answers.

    most : iterations; by default as many as a full polish may take.
    """
    free = _free(task, supports)
    lanes = broadcast_lanes(u * free, free, task.arguments.row_weight, sign)
    if task.system.decided_by is DecidedBy.BOUNDS:
        form = Form(task.system, task.shared, "roots", task.size)
        return polish_bounded(
            task, form, lanes, count_arguments(task), method.progress, method.rows
        )
    solver, kind = spending(task, method, most)
    solution = method.run(task, solver, kind, lanes, effort_arguments(task))
    x, status, iterations = (
        np.asarray(leaf) for leaf in (solution.x, solution.status, solution.iterations)
    )
    return evaluate(task, x[..., : task.size], status, iterations, sign)


def spending(task: SparseTask, method: Method, most: int | None = None) -> tuple[Solver, str]:
    """Choose the solver of the least effort on a support, and the kind of its programme."""

    def up_to(schedule: Schedule) -> Schedule:
        return schedule if most is None else replace(schedule, max_iterations=most)

    if method.stages_for(task):
        return RiccatiLagrangian(up_to(STAGED)), "stages"
    if method.spends_least_for(task):
        return LeastEffort(up_to(LEAST)), "effort"
    if method.decides == "l1":
        return method.lagrangian(up_to(SLACK)), "slacks"
    return method.lagrangian(up_to(POLISH)), "sparse"
