"""Augmented-Lagrangian method for small dense programmes.

As for slews the loop is flat: a pass evaluates derivatives once, decides, and moves once.  Inside
the augmented Lagrangian, with its exact Hessian, is minimised over the box; whenever that has
ended, steps of stabilised SQP are tried from there and kept while the residual of the first-order
conditions falls.  Where the violation does not shrink it is minimised by itself, to tell locally
infeasible from slow.

With trust region, trials of Newton steps, restoration and the best point met, its outer part
decides otherwise than `augmented_lagrangian.outer`.

Sources: Nocedal & Wright (2006), chapter 17; Andreani, Birgin, Martinez & Schuverdt (2007) for the
updates; Gill & Robinson (2013) for the combination with stabilised SQP; Waechter & Biegler (2006)
for scaling and residuals.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.dense.advance import advance
from jaxatt.optimize.dense.arrays import choose, namespace, no
from jaxatt.optimize.dense.called import AnyFunctions
from jaxatt.optimize.dense.constraints import Box, constraints_of
from jaxatt.optimize.dense.decide import decide
from jaxatt.optimize.dense.look import look
from jaxatt.optimize.dense.residuals import Residuals, largest
from jaxatt.optimize.dense.scaling import scaling_of
from jaxatt.optimize.dense.start import Beginning, Draws, begin
from jaxatt.optimize.dense.state import (
    FIRST_GOAL,
    RUNNING,
    Anchor,
    Limits,
    Phase,
    Record,
    State,
)
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trials import try_out
from jaxatt.optimize.solver import Solver
from jaxatt.optimize.status import Status


class Ending(NamedTuple):
    """Result of one start: its best point, status () and iterations ()."""

    found: Record
    status: Array
    iterations: Array


class Case(NamedTuple):
    """What all starts share: the user's arguments and the bounds of the variables."""

    values: Any
    box: Box


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class DenseLagrangian(Solver):
    """Augmented-Lagrangian method for `Functions` of few variables; a start is its `Draws`.

    inner : "newton", "gauss-newton", "lbfgs" or "adam".
    """

    limits: Limits
    inner: str = field(default="newton", metadata={"static": True})

    name = "dense augmented Lagrangian"
    supports = frozenset({features.FEW_VARIABLES, features.EQUALITY, features.INEQUALITY})
    needs = frozenset({features.FEW_VARIABLES})
    calls_lapack = True
    batch_axis = 0
    passes = 50

    def init(self, program: AnyFunctions, start: Draws, args: Case) -> tuple[Beginning, State]:
        """State of a start at its first finite point, with its scaling."""
        began = begin(program, start, args.values, args.box)
        return began, _first(self._task(program, began, args), began)

    def step(
        self, program: AnyFunctions, state: tuple[Beginning, State], args: Case
    ) -> tuple[Beginning, State]:
        """Evaluate derivatives once, decide, and move once."""
        began, s = state
        return began, _next(self._task(program, began, args), s)

    def done(self, state: tuple[Beginning, State]) -> Array:
        """Whether the start has ended or run out of passes."""
        _, s = state
        return (s.status != RUNNING) | (s.iterations >= self.limits.max_iterations)

    def result(self, program: AnyFunctions, state: tuple[Beginning, State], args: Case) -> Ending:
        """Best point of a start."""
        began, s = state
        return _ending(s, self.limits, began.unit)

    def run(self, program: AnyFunctions, start: Draws, args: Case) -> Ending:
        """Run one start to its result on the host, where arrays are NumPy's."""
        began = begin(program, start, args.values, args.box)
        task = self._task(program, began, args)
        s = _first(task, began)
        while not self.done((began, s)):
            s = _next(task, s)
        return _ending(s, self.limits, began.unit)

    def _task(self, program: AnyFunctions, began: Beginning, args: Case) -> Task:
        box, unit = args.box, began.unit
        constraints = constraints_of(
            Box(box.lower / unit, box.upper / unit), *program.counts(began.x, args.values)
        )
        scaling, own_penalty = scaling_of(unit, began.scale), 1.0 / began.scale[1:] ** 2
        return Task(
            program, args.values, constraints, scaling, own_penalty, self.limits, self.inner
        )


def _next(task: Task, s: State) -> State:
    """Run one iteration."""
    s, seen = look(task, s)
    decision = decide(task, s, seen)
    return advance(task, s, seen, decision, try_out(task, s, seen, decision))


def _first(task: Task, began: Beginning) -> State:
    """State before the first iteration."""
    xp, x = namespace(began.x), began.x / began.unit
    no_rows, no_bounds = xp.zeros(began.rows.shape[0] - 1), xp.zeros(2 * x.shape[0])
    infinite = xp.asarray(xp.inf, x.dtype)
    none, never = xp.asarray(0), xp.asarray(False)
    unknown = Residuals(infinite, infinite, infinite, infinite, no_rows, no_bounds)
    blank = Record(x, no_rows, infinite, unknown)
    rows = began.rows * task.scaling.rows
    amiss = 0.5 * xp.sum(task.constraints.violated(rows[1:]) ** 2)
    penalty = 10.0 * xp.maximum(1.0, abs(rows[0])) / xp.maximum(1.0, amiss)
    return State(
        x=x,
        safe=x,
        outer=x,
        multipliers=no_rows,
        penalty=xp.clip(xp.where(xp.isfinite(penalty), penalty, 1.0), 1e-2, 1e2),
        radius=xp.maximum(1.0, 0.1 * largest(x)),
        goal=xp.asarray(FIRST_GOAL, x.dtype),
        phase=xp.asarray(int(Phase.DESCENT)),
        anchor=Anchor(x, no_rows, infinite),
        inner=none,
        stuck=never,
        curved=never,
        violation=infinite,
        stalls=none,
        resets=none,
        restorations=none,
        escapes=none,
        retreats=none,
        settled=none,
        finishing=never,
        stationary=blank,
        feasible=blank,
        closest=blank,
        status=xp.where(began.finite, RUNNING, Status.NOT_FINITE),
        iterations=none,
        method=task.first_order.init(x) if task.first_order is not None else None,
    )


def _ending(end: State, limits: Limits, unit: Array) -> Ending:
    """Best point of a start with the status that its residuals justify."""
    xp = namespace(unit)
    converged = end.stationary.residuals.total <= limits.tolerance
    feasible = end.feasible.residuals.violation <= limits.tolerance
    unbounded = end.status == Status.UNBOUNDED
    converged = converged & no(unbounded)
    last = Status.ITERATION_LIMIT
    status = xp.where(end.status == RUNNING, last, end.status)
    status = xp.where(status == Status.CONVERGED, last, status)
    status = xp.where(feasible & no(unbounded), Status.FEASIBLE, status)
    status = xp.where(converged, Status.CONVERGED, status)
    found = choose(feasible, end.feasible, end.closest)
    found = choose(unbounded, end.closest, found)
    found = choose(unbounded & feasible, end.feasible, found)
    found = choose(converged, end.stationary, found)
    found = found._replace(x=found.x * unit)
    return Ending(found, status, end.iterations)
