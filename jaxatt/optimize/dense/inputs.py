"""Check the arguments of `minimize` and bring them into shape."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.augmented_lagrangian.inner import DENSE_NAMES
from jaxatt.optimize.dense.called import REMEMBERED
from jaxatt.optimize.dense.constraints import Box
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.state import Limits

Floats = npt.NDArray[np.float64]

_MANY_VARIABLES = 300
_FEW_STARTS = 16
_WORTH_COMPILING = 256
_ITERATIONS = {"newton": 500, "gauss-newton": 1000, "lbfgs": 5000, "adam": 50_000}
_INNER = {"newton": 60, "gauss-newton": 100, "lbfgs": 300, "adam": 3000}


def limits_of(tolerance: float, max_iterations: int | None, inner: str) -> Limits:
    """Tolerance and iteration limits, with defaults that fit the inner minimiser."""
    if not (np.isreal(tolerance) and 0 < tolerance < np.inf):
        raise ValueError(f"tolerance = {tolerance!r}: must be a positive number, e.g. 1e-6")
    passes = _ITERATIONS[inner] if max_iterations is None else max_iterations
    if int(passes) != passes or passes < 1:
        raise ValueError(f"max_iterations = {max_iterations!r}: must be a whole number, at least 1")
    return Limits(np.float64(tolerance), np.int64(passes), np.int64(_INNER[inner]))  # type: ignore[arg-type]


def starts_of(x0: Any, starts: int) -> Floats:
    """The starts that the user gives, (k, n)."""
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


def box_of(lower: Any, upper: Any, n: int) -> Box:
    """Bounds on the variables, (n,) each."""
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
    return Box(*sides)  # type: ignore[arg-type]


def inner_of(inner: str, n: int) -> str:
    """Name of the inner minimiser."""
    if inner == "auto":
        return "newton" if n <= _MANY_VARIABLES else "lbfgs"
    if inner not in DENSE_NAMES:
        raise ValueError(
            f"inner = {inner!r}: unknown; choose one of auto, {', '.join(DENSE_NAMES)}"
        )
    return inner


def loop_of(loop: str, inner: str, problem: Hashable, starts: int) -> str:
    """Where the loop of so many starts runs: "host" or "compiled"."""
    exact = inner in ("newton", "gauss-newton")
    if loop not in ("auto", "host", "compiled"):
        raise ValueError(f"loop = {loop!r}: unknown; choose one of auto, host, compiled")
    if loop == "host" and not exact:
        raise ValueError(f"loop = 'host': inner = {inner!r} is compiled; choose 'auto'")
    if loop != "auto":
        return loop
    known = _known(problem)
    if not exact or starts > _FEW_STARTS or known.on_host >= _WORTH_COMPILING:
        return "compiled"
    known.on_host += starts
    return "host"


@functools.cache
def _first_seed() -> tuple[int, ...]:
    return seed_of(jax.random.key(0))


def seed_of(key: Array | None) -> tuple[int, ...]:
    """Numbers of a random key, from which starts are drawn."""
    if key is None:
        return _first_seed()
    if not (isinstance(key, jax.Array) and jnp.issubdtype(key.dtype, jax.dtypes.prng_key)):
        raise ValueError(f"key = {key!r}: must be a typed key, e.g. jax.random.key(0)")
    if key.shape != ():
        raise ValueError(f"key has shape {key.shape}: must be a single key, e.g. jax.random.key(0)")
    return tuple(np.asarray(jax.random.key_data(key)).ravel().tolist())


def problem_of(functions: Functions, x: Floats, args: tuple[Any, ...]) -> Hashable:
    """Key of a problem: its functions and the shapes of their arguments."""
    leaves, tree = jax.tree.flatten(args)
    return functions, x.shape, tree, tuple((np.shape(v), jnp.result_type(v)) for v in leaves)


@dataclass
class _Known:
    """What is known of a problem.

    counts : number of equalities and inequalities.  on_host : starts that ran on the host because
    nothing else was asked for.
    """

    counts: tuple[int, int] | None = None
    on_host: int = 0


@functools.lru_cache(REMEMBERED)
def _known(problem: Hashable) -> _Known:
    return _Known()


def counts_of(
    functions: Functions, x: Floats, args: tuple[Any, ...], problem: Hashable
) -> tuple[int, int]:
    """Number of equalities and inequalities, after checking what the functions return."""
    known = _known(problem)
    if known.counts is None:
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
            _check_call(name, function, (x, *args))
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
        known.counts = (counts[1], counts[2])
    return known.counts


def _check_call(name: str, function: Callable[..., Any], given: tuple[Any, ...]) -> None:
    """Refuse a function that takes another number of arguments than it is given."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some built in ones have none
        return
    try:
        signature.bind(*given)
    except TypeError as error:
        raise ValueError(
            f"{name}: does not take (x, *args) with {len(given) - 1} in args ({error}); write it "
            "as f(x), or give what else it takes as args = (...)"
        ) from None
