"""Minimise any smooth function of few variables under constraints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.multistart.driver import Plain, run_starts
from jaxatt.multistart.on_host import run_on_host
from jaxatt.optimize.dense.called import CalledFunctions
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.inputs import (
    Floats,
    box_of,
    counts_of,
    inner_of,
    limits_of,
    loop_of,
    problem_of,
    seed_of,
    starts_of,
)
from jaxatt.optimize.dense.solver import Case, DenseLagrangian
from jaxatt.optimize.dense.start import Draws, draw
from jaxatt.optimize.status import Status
from jaxatt.runtime.settings import check_precision

ArrayLike = Any

_RESCUES = 4


@dataclass(frozen=True)
class KKTMultipliers:
    """Multipliers of f + equality'h - inequality'g - lower'(x - l) - upper'(u - x).

    equality : (m,), of any sign.  inequality : (p,), lower, upper : (n,), not negative.
    """

    equality: Floats
    inequality: Floats
    lower: Floats
    upper: Floats


@dataclass(frozen=True)
class MinimizeStarts:
    """Outcome of every start; leading axis S.  Fields as in `Minimum`."""

    x: Floats
    objective: Floats
    status: npt.NDArray[np.int64]
    max_violation: Floats
    stationarity: Floats
    multipliers: KKTMultipliers
    iterations: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Minimum:
    """Answer of `minimize`.

    x : (n,).  objective : at x.  status : `Status`.  max_violation : largest violation of a
    constraint at x, in its own unit; bounds hold exactly.  stationarity : scaled residual of the
    other first-order conditions at x.  iterations : passes of the start that gave x.
    starts : all of them, those drawn to the rescue included.
    """

    x: Floats
    objective: float
    status: Status
    max_violation: float
    stationarity: float
    multipliers: KKTMultipliers
    iterations: int
    starts: MinimizeStarts

    def __repr__(self) -> str:
        ended = np.bincount(self.starts.status, minlength=len(Status))
        tally = ", ".join(f"{ended[s]} {s.name}" for s in Status if ended[s])
        return (
            f"{self.status.name}: {self.status.meaning}\n"
            f"  x              {np.array2string(self.x, threshold=12, precision=8)}\n"
            f"  objective      {self.objective:.10g}\n"
            f"  max violation  {self.max_violation:.3g}\n"
            f"  stationarity   {self.stationarity:.3g}\n"
            f"  iterations     {self.iterations}\n"
            f"  starts         {tally}"
        )


def minimize(
    objective: Callable[..., Any],
    x0: ArrayLike,
    args: tuple[Any, ...] = (),
    *,
    equality: Callable[..., Any] | None = None,
    inequality: Callable[..., Any] | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    tolerance: float = 1e-6,
    max_iterations: int | None = None,
    starts: int = 1,
    key: Array | None = None,
    inner: str = "auto",
    loop: str = "auto",
) -> Minimum:
    """Minimise objective(x, *args) subject to equality == 0, inequality >= 0, lower <= x <= upper.

    objective, equality, inequality : smooth JAX functions of (x, *args), x (n,); the first returns
    a scalar, the others a scalar or a vector.  Pass the same function objects again and nothing
    is compiled again; a lambda written inside a loop is a new function every time.
    x0 : (n,), or (S, n) for S starts of one's own.  It may lie outside the bounds.
    args : pytrees of arrays; new values of the same shapes do not recompile.
    lower, upper : scalar or (n,), may hold -inf and inf, may be equal.  The functions are never
    evaluated outside.
    tolerance : on violation (in the constraints' own units) and on scaled stationarity.
    max_iterations : passes of one start; by default 500 with "newton".
    starts : with x0 (n,), x0 itself and starts - 1 drawn around it: spread by max(1, |x0|), or
    over the box where it is bounded.  With x0 (S, n) it has to be 1 or S.
    key : of the draws, `jax.random.key(0)` by default; start i depends on key and i alone.
    inner : "newton" (exact Hessian), "gauss-newton" (no curvature of the constraints), "lbfgs",
    "adam", or "auto": "newton" up to 300 variables, "lbfgs" beyond.

    loop : "host" compiles the functions alone and runs the solver from Python, one start after the
    other: a new problem is answered soonest.  "compiled" compiles it with them, which takes seconds
    but less for every start, and runs all side by side.  "auto" is "host" for up to 16 starts,
    until a problem has had 256; "lbfgs" and "adam" are always compiled.  Both take the same steps,
    to rounding.

    The best start is returned: converged before feasible before anything else, then by objective.
    Where none gets there a few more starts are drawn in the same way.
    `Status.CONVERGED` means that violation and stationarity hold at the returned x; INFEASIBLE
    that x, within its bounds, is a stationary point of half the squared violation in the
    constraints' own units, so other starts may still get there.

    Raises ValueError where the input does not make sense.
    """
    check_precision()
    args = args if isinstance(args, tuple) else (args,)
    begin = starts_of(x0, starts)
    n = begin.shape[1]
    box = box_of(lower, upper, n)
    chosen = inner_of(inner, n)
    limits = limits_of(tolerance, max_iterations, chosen)
    functions = Functions(objective, equality, inequality)
    solver = DenseLagrangian(limits, chosen)
    problem = problem_of(functions, begin[0], args)
    m, p = counts_of(functions, begin[0], args, problem)
    seed = seed_of(key)
    own = begin.shape[0]
    total = max(own, int(starts))
    where = loop_of(loop, chosen, problem, total)
    run = _runner(where, solver, functions, Case(args, box), (m, p), total)
    ends: list[Any] = []
    for round_ in range(1 + _RESCUES):
        first = round_ * total
        index = np.arange(first, first + total)
        draws = draw(begin, index, box, seed)
        ends.append(run(draws))
        status = ends[-1].status
        if ((status == Status.CONVERGED) | (status == Status.UNBOUNDED)).any():
            break
        if round_ > 0 and any((end.status == Status.FEASIBLE).any() for end in ends):
            break
    several = len(ends) > 1
    every = jax.tree.map(lambda *leaves: np.concatenate(leaves), *ends) if several else ends[0]
    return _answer(every, m)


def _runner(
    loop: str,
    solver: DenseLagrangian,
    functions: Functions,
    case: Case,
    counts: tuple[int, int],
    total: int,
) -> Callable[[Draws], Any]:
    """What runs starts: on the host, or compiled in chunks of `total`."""
    if loop == "host":
        called = CalledFunctions(functions, *counts)
        return lambda draws: run_on_host(solver, called, draws, case)
    return lambda draws: run_starts(solver, Plain(functions), draws, case, rows=total)


def _answer(ends: Any, m: int) -> Minimum:
    found, status = ends.found, ends.status
    residuals = found.residuals
    own, bounds, n = residuals.multipliers, residuals.bounds, found.x.shape[1]
    every = MinimizeStarts(
        found.x,
        found.objective,
        status.astype(int),
        residuals.violation,
        residuals.stationarity,
        KKTMultipliers(own[:, :m], np.maximum(0.0, -own[:, m:]), bounds[:, :n], bounds[:, n:]),
        ends.iterations.astype(int),
    )
    best = _best(every)
    mine = every.multipliers
    return Minimum(
        every.x[best],
        float(every.objective[best]),
        Status(int(every.status[best])),
        float(every.max_violation[best]),
        float(every.stationarity[best]),
        KKTMultipliers(
            mine.equality[best], mine.inequality[best], mine.lower[best], mine.upper[best]
        ),
        int(every.iterations[best]),
        every,
    )


_PREFERENCE = {
    Status.UNBOUNDED: 0,
    Status.CONVERGED: 1,
    Status.FEASIBLE: 2,
    Status.INFEASIBLE: 3,
    Status.ITERATION_LIMIT: 3,
    Status.NOT_FINITE: 4,
}


def _best(every: MinimizeStarts) -> int:
    """Index of the best start: converged, then feasible, by objective; else the least violation."""
    rank = np.array([_PREFERENCE[Status(int(s))] for s in every.status])
    value = np.where(rank <= 2, every.objective, every.max_violation)
    value = np.where(np.isfinite(value), value, np.where(rank == 0, -np.inf, np.inf))
    return int(np.lexsort([value, rank])[0])
