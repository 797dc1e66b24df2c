"""Arrays of the dense solver: NumPy's where its loop runs on the host, JAX's where it is compiled.

The solver is written once, for the names that both have.  Here is what they do not share: how
choices are made, loops run and systems solved, and what may be left out because its outcome is
already known.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax


def _where(condition: Any, yes: Any, no: Any) -> Any:
    """`numpy.where` that takes a short way for one condition: it decides most of the solver."""
    if type(condition) is np.bool_:
        chosen, other = (yes, no) if condition else (no, yes)
        kind = type(chosen)
        if kind is np.ndarray:
            return chosen
        if type(other) is not np.ndarray:
            return chosen if kind in _SCALARS else _scalar(chosen)
    return np.where(condition, yes, no)


def _scalar(value: Any) -> Any:
    if isinstance(value, float):
        return np.float64(value)
    return np.bool_(value) if isinstance(value, bool) else np.int64(value)


def _asarray(value: Any, dtype: Any = None) -> Any:
    return np.asarray(value, dtype)[()]


def _max(values: Any, axis: int | None = None, initial: Any = None) -> Any:
    if values.ndim == 1 and values.shape[0]:
        largest = values[values.argmax()]
        return largest if initial is None else _maximum(largest, initial)
    if values.ndim == 0:
        return values if initial is None else _maximum(values, initial)
    return np.maximum.reduce(values, axis, initial=initial)


def _sum(values: Any, axis: int | None = None) -> Any:
    return np.add.reduce(values, axis)


def _all(values: Any, axis: int | None = None) -> Any:
    return np.logical_and.reduce(values, axis)


def _any(values: Any, axis: int | None = None) -> Any:
    return np.logical_or.reduce(values, axis)


def _argmin(values: Any) -> Any:
    return values.argmin()


def _diag(values: Any) -> Any:
    return values.diagonal() if values.ndim == 2 else np.diag(values)


def _zeros_like(values: Any) -> Any:
    return np.zeros(values.shape, values.dtype)


def _maximum(one: Any, other: Any) -> Any:
    if type(one) in _NUMBERS and type(other) in _NUMBERS:
        return np.float64(one if one >= other or one != one else other)
    return np.maximum(one, other)


def _minimum(one: Any, other: Any) -> Any:
    if type(one) in _NUMBERS and type(other) in _NUMBERS:
        return np.float64(one if one <= other or one != one else other)
    return np.minimum(one, other)


def _clip(value: Any, low: Any, high: Any) -> Any:
    return _minimum(_maximum(value, low), high)


@functools.cache
def _eye(rows: int, columns: int | None = None, dtype: Any = None) -> Any:
    found = np.eye(rows, columns)
    found.flags.writeable = False
    return found


_KNOWN = frozenset((np.ndarray, np.float64, np.int64, np.bool_))
_YES, _NO = np.bool_(True), np.bool_(False)
_NUMBERS = frozenset((np.float64, float, int))
_SCALARS = frozenset((np.float64, np.int64, np.bool_))

_OWN = {
    **{"where": _where, "asarray": _asarray, "max": _max, "sum": _sum, "all": _all, "any": _any},
    **{"maximum": _maximum, "minimum": _minimum, "clip": _clip, "eye": _eye, "diag": _diag},
    **{"argmin": _argmin, "zeros_like": _zeros_like},
}
"""Faster for few numbers than NumPy's, which look at their arguments for longer."""

_HOST = SimpleNamespace(**{**vars(np), **_OWN})


def on_host(value: Any) -> bool:
    """Whether a value is known here and now."""
    return type(value) in _KNOWN


def namespace(value: Any) -> Any:
    """The array functions for a value."""
    return _HOST if type(value) in _KNOWN else jnp


def certain(condition: Any) -> bool:
    """Whether a condition is known to hold; never while the solver is being compiled."""
    return type(condition) is np.bool_ and bool(condition)


def no(condition: Any) -> Any:
    """Its contrary; NumPy's takes long for a single one."""
    if type(condition) is np.bool_:
        return _NO if condition else _YES
    return ~condition


def same(one: Array, other: Array) -> bool:
    """Whether two arrays of the host hold the same."""
    return one.tobytes() == other.tobytes()


def rows_where(chosen: Array, *values: Array) -> tuple[Array, ...]:
    """The rows that are chosen, (q,) bool; while compiling all of them, the others zero."""
    if not on_host(chosen):
        return tuple(jnp.where(chosen if v.ndim == 1 else chosen[:, None], v, 0.0) for v in values)
    index = chosen.nonzero()[0]
    return values if len(index) == len(chosen) else tuple(v[index] for v in values)


def put_back(chosen: Array, values: Array) -> Array:
    """What `rows_where` gave, (q,) again, zero where nothing was chosen."""
    if not on_host(chosen):
        return jnp.where(chosen, values, 0.0)
    full = np.zeros(len(chosen))
    full[chosen] = values
    return full  # type: ignore[return-value]


def choose(condition: Any, yes: Any, no: Any) -> Any:
    """Leafwise `where` with a scalar condition."""
    if type(condition) is np.bool_:
        return yes if condition else no
    return jax.tree.map(lambda a, b: a if a is b else jnp.where(condition, a, b), yes, no)


def repeat(
    times: int, body: Callable[[Any], Any], carry: Any, settled: Callable[[Any, Any], Any]
) -> Any:
    """Apply `body` to `carry` several times.

    carry : of arrays, a tuple or one (k,).  settled : (old, new) -> () bool, no further time would
    change anything: the host stops there.
    """
    if not on_host(carry[0]):
        return lax.fori_loop(0, times, lambda _, some: body(some), carry)
    for _ in range(times):
        old, carry = carry, body(carry)
        if settled(old, carry):
            break
    return carry


def solve(matrix: Array, right: Array) -> Array:
    """Solution (n,) of a linear system; nothing finite where it is singular."""
    if not on_host(matrix):
        return jnp.linalg.solve(matrix, right)
    try:
        return np.linalg.solve(matrix, right)  # type: ignore[return-value]
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)  # type: ignore[return-value]


def eigh(matrix: Array) -> tuple[Array, Array]:
    """Eigenvalues and eigenvectors; nothing finite where they are not found."""
    if not on_host(matrix):
        values, vectors = jnp.linalg.eigh(matrix)
        return values, vectors
    try:
        return np.linalg.eigh(matrix)  # type: ignore[return-value]
    except np.linalg.LinAlgError:
        return np.full(len(matrix), np.nan), np.full(matrix.shape, np.nan)  # type: ignore[return-value]
