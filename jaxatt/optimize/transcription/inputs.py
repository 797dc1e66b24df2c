"""Check and convert the arguments of `transcribe`: counts, vectors, bounds, final time."""

from __future__ import annotations

import numbers
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats


def count_of(name: str, value: Any) -> int:
    """Check a whole number of at least 1."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 1:
        raise ValueError(f"{name} is {value!r}; a whole number from 1 on is expected")
    return int(value)


def _numbers(name: str, value: Any) -> Floats:
    try:
        found = np.asarray(value, float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; numbers are expected") from None
    if np.isnan(found).any():
        raise ValueError(f"{name} is {value!r}; a number that is not one is not allowed")
    return found


def vector_of(name: str, value: Any, size: int) -> Callable[[Any], Array]:
    """Function of the parameters that returns (size,), from an array or such a function."""
    if callable(value):
        return lambda p: jnp.asarray(value(p), float)
    found = _numbers(name, value)
    if found.shape != (size,):
        raise ValueError(f"{name} has shape {found.shape}; ({size},) is expected")
    return lambda p: jnp.asarray(found)


def _pair(name: str, value: Any) -> tuple[Any, Any]:
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise ValueError(f"{name} is {value!r}; a pair (lower, upper) is expected")
    return value[0], value[1]


def _spread(name: str, value: Any, size: int | None) -> Floats:
    found = _numbers(name, value)
    if size is None:
        return np.atleast_1d(found)
    if found.shape not in ((), (1,), (size,)):
        raise ValueError(f"{name} has shape {found.shape}; () or ({size},) is expected")
    return np.broadcast_to(found, (size,)).copy()


def constant_bounds(name: str, value: Any, size: int | None) -> tuple[Floats, Floats]:
    """Lower and upper bounds, (size,) each, infinite by default."""
    if value is None:
        return np.full(size or 0, -np.inf), np.full(size or 0, np.inf)
    pair = _pair(name, value)
    lower, upper = (_spread(f"{name}[{k}]", one, size) for k, one in enumerate(pair))
    if lower.shape != upper.shape:
        raise ValueError(
            f"{name} has shapes {lower.shape} and {upper.shape}; the same ones are expected"
        )
    crossing(name, lower, upper)
    return lower, upper


def crossing(name: str, lower: Floats, upper: Floats) -> None:
    """Raise ValueError where a lower bound is not below the upper one."""
    wrong = np.flatnonzero(~(lower < upper))
    if len(wrong):
        k = int(wrong[0])
        raise ValueError(
            f"{name}: lower {lower[k]:g} and upper {upper[k]:g} of number {k} cross; "
            "every lower bound has to be below its upper one"
        )


def bounds_of(name: str, value: Any, size: int) -> Callable[[Any], tuple[Array, Array]] | None:
    """Function of the parameters that returns lower and upper bounds, (size,) each."""
    if value is None:
        return None
    if not callable(value):
        lower, upper = constant_bounds(name, value, size)
        return lambda p: (jnp.asarray(lower), jnp.asarray(upper))

    def found(p: Any) -> tuple[Array, Array]:
        lower, upper = _pair(name, value(p))
        both = (jnp.asarray(lower, float), jnp.asarray(upper, float))
        for one in both:
            if one.shape not in ((), (1,), (size,)):
                raise ValueError(f"{name} has shape {one.shape}; () or ({size},) is expected")
        return jnp.broadcast_to(both[0], (size,)), jnp.broadcast_to(both[1], (size,))

    return found


def time_of(value: Any) -> tuple[Callable[[Any], Array] | None, tuple[float, float]]:
    """Fixed final time as a function of the parameters, or None and its limits."""
    if callable(value):
        return (lambda p: jnp.asarray(value(p), float)), (0.0, np.inf)
    if isinstance(value, (tuple, list)):
        shortest, longest = (
            float(_spread("final_time", one, 1)[0]) for one in _pair("final_time", value)
        )
        if shortest < 0.0 or not shortest < longest:
            raise ValueError(
                f"final_time is {value!r}; (shortest, longest) with 0 <= shortest < longest "
                "is expected"
            )
        return None, (shortest, longest)
    fixed = _numbers("final_time", value)
    if fixed.shape != () or not 0.0 < fixed < np.inf:
        raise ValueError(f"final_time is {value!r}; a positive number [s] is expected")
    return (lambda p: jnp.asarray(fixed)), (0.0, np.inf)
