"""Check that parameters fit a problem in continuous time: shapes, bounds, values, manifold.

All of it happens before anything is solved; what is wrong is named, with what was expected.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.manifold_check import check_manifold
from jaxatt.optimize.transcription.continuous import Continuous
from jaxatt.optimize.transcription.inputs import crossing
from jaxatt.runtime.settings import RUNS_ONCE


def check_parameters(of: Continuous, p: Any) -> None:
    """Raise ValueError where functions of the parameters return what they should not."""
    try:
        _check(of, p)
    except KeyError as error:
        raise ValueError(
            f"parameters: functions of the problem ask for {error}, which is not among them; add it"
        ) from error


def _check(of: Continuous, p: Any) -> None:
    start = _value("initial_state", of.initial_state, (of.states,), p)
    if not np.isfinite(start).all():
        raise ValueError(f"initial_state is {start}; finite numbers are expected")
    if of.duration is not None:
        final = _value("final_time", of.duration, (), p)
        if not 0.0 < final < np.inf:
            raise ValueError(f"final_time is {final}; a positive number [s] is expected")
    if of.control_bounds is not None:
        lower, upper = of.control_bounds(p)
        crossing("control_bounds", np.asarray(lower), np.asarray(upper))
    _check_rows(of, p)
    if of.retract is not None:
        assert of.difference is not None
        check_manifold(of.retract, of.difference, jnp.asarray(start), of.error_size)


def _value(name: str, function: Callable[[Any], Array], shape: tuple[int, ...], p: Any) -> Any:
    found = np.asarray(function(p))
    if found.shape != shape:
        raise ValueError(f"{name} has shape {found.shape}; {shape} is expected")
    return found


def _rows(of: Continuous) -> dict[str, tuple[Any, tuple[int, ...] | None, bool]]:
    """The user's functions by name, with the expected shape and whether they are terminal.

    A shape of None stands for rows of any number.
    """
    every = {
        "dynamics": (of.dynamics, (of.states,), False),
        "running_cost": (of.running_cost, (), False),
        "path_equality": (of.path_equality, None, False),
        "path_inequality": (of.path_inequality, None, False),
        "terminal_cost": (of.terminal_cost, (), True),
        "terminal_equality": (of.terminal_equality, None, True),
        "terminal_inequality": (of.terminal_inequality, None, True),
    }
    return {name: row for name, row in every.items() if row[0] is not None}


@functools.cache
def _evaluated(of: Continuous) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """(y, v, p) -> values of all functions by name, and values and derivatives, compiled."""
    rows = _rows(of)

    def values(y: Array, v: Array, p: Any) -> dict[str, Array]:
        extras, x = of.extras(y, jnp.zeros(()), p), y[: of.states]
        u = of.unscaled(v, p)
        return {
            name: jnp.asarray(function(x, p, extras) if last else function(x, u, p, extras))
            for name, (function, _, last) in rows.items()
        }

    def derived(y: Array, v: Array, p: Any) -> Any:
        return values(y, v, p), jax.jacfwd(values, argnums=(0, 1))(y, v, p)

    return values, jax.jit(derived, compiler_options=RUNS_ONCE)


def _check_rows(of: Continuous, p: Any) -> None:
    """Check shapes and finite values of all functions and derivatives at the first state."""
    rows = _rows(of)
    y, v = of.guess(p), jnp.zeros(of.controls)
    evaluate, derive = _evaluated(of)
    for name, found in jax.eval_shape(evaluate, y, v, p).items():
        expected = rows[name][1]
        fits = len(found.shape) <= 1 if expected is None else found.shape == expected
        if not fits:
            wanted = "() or (rows,)" if expected is None else f"{expected}"
            raise ValueError(
                f"{name} returns an array of shape {found.shape}; {wanted} is expected"
            )
    values, slopes = derive(y, v, p)
    where = f"x = {np.asarray(y[: of.states])}, u = {np.asarray(of.unscaled(v, p))}"
    for name in rows:
        value = np.asarray(values[name])
        if not np.isfinite(value).all():
            raise ValueError(
                f"{name} is {value} at the first evaluation, {where}; finite numbers are expected"
            )
        if not all(np.isfinite(np.asarray(slope)).all() for slope in slopes[name]):
            raise ValueError(
                f"{name} has a derivative that is not finite at the first evaluation, {where}; "
                "write it so that it can be differentiated there"
            )
