"""A general entry to the solver: any smooth programme with few variables."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.residuals import Box
from jaxatt.optimize.dense.solver import Ending, solve
from jaxatt.optimize.dense.start import Draws, draw
from jaxatt.optimize.dense.state import Limits
from jaxatt.optimize.inner import DENSE_NAMES
from jaxatt.optimize.status import Status

Floats = npt.NDArray[np.float64]
ArrayLike = Any

_MANY_VARIABLES = 300
_ITERATIONS = {"newton": 500, "gauss-newton": 1000, "lbfgs": 5000, "adam": 50_000}
_INNER = {"newton": 60, "gauss-newton": 100, "lbfgs": 300, "adam": 3000}
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
    """How every start ended; leading axis S.  Fields as in `Minimum`."""

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

    The best start is returned: converged before feasible before anything else, then by objective.
    Where none gets there a few more starts are drawn in the same way.
    `Status.CONVERGED` means that violation and stationarity hold at the returned x; INFEASIBLE
    that x is a stationary point of the violation, so other starts may still get there.

    Raises ValueError where the input does not make sense.
    """
    if jnp.result_type(float) != jnp.float64:
        raise ValueError(
            "jax_enable_x64 is off: the solver's tolerances need 64-bit floats; call "
            'jax.config.update("jax_enable_x64", True) before the first use of JAX'
        )
    args = args if isinstance(args, tuple) else (args,)
    begin = _starts_of(x0, starts)
    n = begin.shape[1]
    box = _box(lower, upper, n)
    if not (np.isreal(tolerance) and 0 < tolerance < np.inf):
        raise ValueError(f"tolerance = {tolerance!r}: must be a positive number, e.g. 1e-6")
    chosen = _inner(inner, n)
    passes = _ITERATIONS[chosen] if max_iterations is None else max_iterations
    if int(passes) != passes or passes < 1:
        raise ValueError(f"max_iterations = {max_iterations!r}: must be a whole number, at least 1")
    functions = Functions(objective, equality, inequality)
    m, p = _counts(functions, begin[0], args)
    limits = Limits(
        jnp.asarray(float(tolerance)), jnp.asarray(int(passes)), jnp.asarray(_INNER[chosen])
    )
    root = _key(key)
    own = begin.shape[0]
    total = max(own, int(starts))
    ends: list[Any] = []
    for round_ in range(1 + _RESCUES):
        first = round_ * total
        index = np.arange(first, first + total)
        ends.append(
            jax.tree.map(
                np.asarray,
                _solve_all(functions, chosen, draw(begin, index, box, root), args, box, limits),
            )
        )
        status = ends[-1].status
        if np.isin(status, (Status.CONVERGED, Status.UNBOUNDED)).any():
            break
        if round_ > 0 and any((end.status == Status.FEASIBLE).any() for end in ends):
            break
    return _answer(jax.tree.map(lambda *leaves: np.concatenate(leaves), *ends), m, p)


@functools.partial(jax.jit, static_argnames=("functions", "inner"))
def _solve_all(
    functions: Functions, inner: str, draws: Draws, args: Any, box: Box, limits: Limits
) -> Ending:
    """All starts of `draws`, leading axis S."""
    return jax.vmap(lambda one: solve(functions, one, args, box, limits, inner))(draws)


def _answer(ends: Any, m: int, p: int) -> Minimum:
    found, status = ends.found, ends.status
    residuals = found.residuals
    own = residuals.multipliers
    every = MinimizeStarts(
        found.x,
        found.objective,
        status.astype(int),
        residuals.violation,
        residuals.stationarity,
        KKTMultipliers(
            own[:, :m], np.maximum(0.0, -own[:, m : m + p]), residuals.lower, residuals.upper
        ),
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
    """Converged first, then feasible, each by objective; otherwise the least violation."""
    rank = np.array([_PREFERENCE[Status(int(s))] for s in every.status])
    value = np.where(rank <= 2, every.objective, every.max_violation)
    value = np.where(np.isfinite(value), value, np.where(rank == 0, -np.inf, np.inf))
    return int(np.lexsort([value, rank])[0])


def _starts_of(x0: ArrayLike, starts: int) -> Floats:
    try:
        begin = np.asarray(x0, float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"x0 = {x0!r}: must be a vector (n,) of numbers, or (S, n)") from error
    if begin.ndim not in (1, 2) or begin.size == 0:
        raise ValueError(
            f"x0 has shape {begin.shape}: must be a vector (n,), or (S, n) for S starts"
        )
    if isinstance(starts, bool) or int(starts) != starts or starts < 1:
        raise ValueError(f"starts = {starts!r}: must be a whole number, at least 1")
    if begin.ndim == 2 and starts not in (1, len(begin)):
        raise ValueError(
            f"starts = {starts}: x0 holds {len(begin)} starts; leave out `starts` or pass one x0"
        )
    return np.atleast_2d(begin)


def _box(lower: ArrayLike | None, upper: ArrayLike | None, n: int) -> Box:
    sides = []
    for name, given, missing in (("lower", lower, -np.inf), ("upper", upper, np.inf)):
        side = np.asarray(missing if given is None else given, float)
        if side.ndim > 1 or side.shape not in ((), (1,), (n,)):
            raise ValueError(f"{name} has shape {side.shape}: must be a scalar or ({n},)")
        side = np.broadcast_to(side, (n,))
        if np.isnan(side).any():
            raise ValueError(f"{name} = {given!r}: holds nan; use -inf or inf for no bound")
        sides.append(side)
    crossed = np.flatnonzero(sides[0] > sides[1])
    if crossed.size:
        i = crossed[0]
        raise ValueError(
            f"lower[{i}] = {sides[0][i]:g} is above upper[{i}] = {sides[1][i]:g}: swap them"
        )
    if (sides[0] == np.inf).any() or (sides[1] == -np.inf).any():
        raise ValueError("lower holds inf or upper -inf: no x is inside; use -inf and inf")
    return Box(jnp.asarray(sides[0]), jnp.asarray(sides[1]))


def _inner(inner: str, n: int) -> str:
    if inner == "auto":
        return "newton" if n <= _MANY_VARIABLES else "lbfgs"
    if inner not in DENSE_NAMES:
        raise ValueError(
            f"inner = {inner!r}: unknown; choose one of auto, {', '.join(DENSE_NAMES)}"
        )
    return inner


def _key(key: Array | None) -> Array:
    if key is None:
        return jax.random.key(0)
    if not (isinstance(key, jax.Array) and jnp.issubdtype(key.dtype, jax.dtypes.prng_key)):
        raise ValueError(f"key = {key!r}: must be a typed key, e.g. jax.random.key(0)")
    if key.shape != ():
        raise ValueError(f"key has shape {key.shape}: must be a single key, e.g. jax.random.key(0)")
    return key


_SHAPES: dict[Any, tuple[int, int]] = {}


def _counts(functions: Functions, x: Floats, args: tuple[Any, ...]) -> tuple[int, int]:
    """Number of equalities and inequalities, after a look at what the functions return."""
    leaves, tree = jax.tree.flatten(args)
    what = (functions, x.shape, tree, tuple((np.shape(v), jnp.result_type(v)) for v in leaves))
    if what not in _SHAPES:
        counts = []
        at = jax.eval_shape(lambda: jnp.zeros(x.shape))
        for name in ("objective", "equality", "inequality"):
            function = getattr(functions, name)
            if function is None:
                if name == "objective":
                    raise ValueError("objective is None: must be a function of (x, *args)")
                counts.append(0)
                continue
            if not callable(function):
                raise ValueError(f"{name} = {function!r}: must be a function of (x, *args)")
            returned = jax.eval_shape(lambda y, a, f=function: jnp.asarray(f(y, *a)), at, args)
            if jnp.issubdtype(returned.dtype, jnp.complexfloating):
                raise ValueError(f"{name} returns complex numbers: must be real")
            most = 0 if name == "objective" else 1
            if len(returned.shape) > most:
                allowed = "a scalar" if most == 0 else "a scalar or a vector"
                raise ValueError(
                    f"{name} returns an array of shape {returned.shape}: must be {allowed}"
                )
            counts.append(int(np.prod(returned.shape)))
        _SHAPES[what] = (counts[1], counts[2])
    return _SHAPES[what]
