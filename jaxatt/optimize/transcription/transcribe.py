"""Transcribe an optimal-control problem in continuous time to a programme over stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.optimal_control import Layout, OptimalControlProgram
from jaxatt.optimize.transcription.checks import check_parameters
from jaxatt.optimize.transcription.continuous import Continuous
from jaxatt.optimize.transcription.derivatives import StageDerivatives, rate_of
from jaxatt.optimize.transcription.inputs import (
    bounds_of,
    constant_bounds,
    count_of,
    time_of,
    vector_of,
)
from jaxatt.optimize.transcription.runge_kutta import Interval, RungeKutta
from jaxatt.optimize.transcription.signatures import takes_extras
from jaxatt.runtime.arrays import Floats

_PATH = ("x", "u", "parameters")
_END = ("x", "parameters")


def transcribe(
    dynamics: Callable[..., Any],
    *,
    states: int,
    controls: int,
    intervals: int,
    initial_state: Any,
    final_time: Any,
    running_cost: Callable[..., Any] | None = None,
    terminal_cost: Callable[..., Any] | None = None,
    terminal_equality: Callable[..., Any] | None = None,
    terminal_inequality: Callable[..., Any] | None = None,
    path_equality: Callable[..., Any] | None = None,
    path_inequality: Callable[..., Any] | None = None,
    control_bounds: Any = None,
    state_bounds: Any = None,
    free_parameters: Any = None,
    retract: Callable[[Array, Array], Array] | None = None,
    difference: Callable[[Array, Array], Array] | None = None,
    error_size: int | None = None,
    steps: int = 1,
) -> OptimalControlProgram:
    """Transcribe an optimal-control problem in continuous time to an `OptimalControlProgram`.

    The horizon is cut into intervals of one length with a constant control each; states at all
    nodes are variables (multiple shooting), and the dynamics and the running cost are integrated
    by the classical Runge-Kutta formula.

    dynamics : (x, u, parameters) -> (states,), dx/dt.  x : (states,).  u : (controls,).
    initial_state : (states,), or a function of the parameters.
    final_time : [s], a number or a function of the parameters; or (shortest, longest), between
        which it is decided, with infinity and 0 where there is no limit.
    running_cost : (x, u, parameters) -> (), integrated over time.
    terminal_cost : (x, parameters) -> (); of the last state, as the next two.
    terminal_equality : -> zero when satisfied.  terminal_inequality : -> not negative.
    path_equality, path_inequality : (x, u, parameters) -> the same at the beginning of every
        interval, with the control that begins there.
    control_bounds : lower and upper, numbers or (controls,), or a function of the parameters that
        returns both.
    state_bounds : lower and upper, numbers or (states,), infinite where there is none; they hold at
        all nodes but the first, whose state is given.
    free_parameters : lower and upper bounds of numbers to be decided with the controls, (m,) each.
    retract : (x, e) -> (states,), the state at an error e (error_size,) from x; difference :
        (x, reference) -> e such that retract(reference, e) = x.  Without them states add up.
    steps : of the Runge-Kutta formula in an interval.

    Every function may name more arguments, after these: `time` [s], `final_time` [s] and `free`
    (m,), the free parameters.

    The parameters are a pytree of arrays; new values do not compile anything again.

    Raises ValueError where the input does not make sense.
    """
    s, b = count_of("states", states), count_of("controls", controls)
    count, steps = count_of("intervals", intervals), count_of("steps", steps)
    if (retract is None) != (difference is None):
        raise ValueError("retract and difference define a manifold together; one of them is None")
    if retract is not None and error_size is None:
        raise ValueError("error_size is None; with retract and difference it is needed")
    duration, time_bounds = time_of(final_time)
    free_lower, free_upper = constant_bounds("free_parameters", free_parameters, None)
    state_lower, state_upper = constant_bounds("state_bounds", state_bounds, s)

    def path(function: Callable[..., Any] | None, name: str) -> Any:
        return None if function is None else takes_extras(function, name, _PATH)

    def end(function: Callable[..., Any] | None, name: str) -> Any:
        return None if function is None else takes_extras(function, name, _END)

    continuous = Continuous(
        states=s,
        controls=b,
        error_size=s if error_size is None else count_of("error_size", error_size),
        dynamics=takes_extras(dynamics, "dynamics", _PATH),
        initial_state=vector_of("initial_state", initial_state, s),
        duration=duration,
        time_bounds=time_bounds,
        free_lower=free_lower,
        free_upper=free_upper,
        control_bounds=bounds_of("control_bounds", control_bounds, b),
        state_lower=state_lower,
        state_upper=state_upper,
        running_cost=path(running_cost, "running_cost"),
        terminal_cost=end(terminal_cost, "terminal_cost"),
        path_equality=path(path_equality, "path_equality"),
        path_inequality=path(path_inequality, "path_inequality"),
        terminal_equality=end(terminal_equality, "terminal_equality"),
        terminal_inequality=end(terminal_inequality, "terminal_inequality"),
        retract=retract,
        difference=difference,
    )
    return _programme(continuous, count, steps)


def _programme(of: Continuous, count: int, steps: int) -> OptimalControlProgram:
    s, n, b = of.states, of.error_size, of.controls
    formula = RungeKutta(
        rate=rate_of(of),
        moving=s,
        total=of.total,
        controls=b,
        costs=of.running_cost is not None,
        steps=steps,
    )

    def retract(y: Array, error: Array) -> Array:
        assert of.retract is not None
        return jnp.concatenate([of.retract(y[:s], error[:n]), y[s:] + error[n:]])

    def difference(y: Array, reference: Array) -> Array:
        assert of.difference is not None
        return jnp.concatenate([of.difference(y[:s], reference[:s]), y[s:] - reference[s:]])

    def extras(y: Array, interval: Interval, p: Any) -> Any:
        return of.extras(y, interval.time, p)

    def limits(interval: Interval, p: Any) -> tuple[Array, Array]:
        assert of.control_bounds is not None
        lower, upper = of.control_bounds(p)
        middle, half = of.scale(p)
        return (lower - middle) / half, (upper - middle) / half

    def equality(y: Array, u: Array, interval: Interval, p: Any) -> Array:
        assert of.path_equality is not None
        row = of.path_equality(y[:s], of.unscaled(u, p), p, extras(y, interval, p))
        return jnp.atleast_1d(row)

    def inequality(y: Array, u: Array, interval: Interval, p: Any) -> Array:
        rows = []
        if of.path_inequality is not None:
            row = of.path_inequality(y[:s], of.unscaled(u, p), p, extras(y, interval, p))
            rows.append(jnp.atleast_1d(row))
        bounded = _within(y[:s], of.state_lower, of.state_upper)
        # Nothing changes the first state.
        rows.append(jnp.where(interval.time > 0.0, bounded, 1.0))
        return jnp.concatenate(rows)

    def ended(y: Array, p: Any) -> Any:
        return y[:s], p, of.extras(y, jnp.ones((), y.dtype), p)

    def final_rows(y: Array, p: Any) -> Array:
        assert of.terminal_equality is not None
        return jnp.atleast_1d(of.terminal_equality(*ended(y, p)))

    def final_inequality(y: Array, p: Any) -> Array:
        rows = []
        if of.terminal_inequality is not None:
            rows.append(jnp.atleast_1d(of.terminal_inequality(*ended(y, p))))
        rows.append(_within(y[:s], of.state_lower, of.state_upper))
        rows.append(_within(of.free(y), of.free_lower, of.free_upper))
        if of.duration is None:
            rows.append(_within_time(of.final_time(y, p), *of.time_bounds))
        return jnp.concatenate(rows)

    def terminal_cost(y: Array, p: Any) -> Array:
        assert of.terminal_cost is not None
        return of.terminal_cost(*ended(y, p))

    def moved(y: Array, u: Array, interval: Interval, p: Any) -> tuple[Array, Array]:
        return formula.step(y, u, interval, p)

    derivatives = StageDerivatives(of, formula)
    bounded_states = bool(np.isfinite([of.state_lower, of.state_upper]).any())
    bounded_end = bounded_states or bool(np.isfinite([of.free_lower, of.free_upper]).any())
    if of.duration is None:
        bounded_end |= of.time_bounds[0] > 0.0 or bool(np.isfinite(of.time_bounds[1]))
    programme = OptimalControlProgram(
        start=of.guess,
        stages=lambda p: Interval(jnp.arange(count) / count, jnp.full(count, 1.0 / count)),
        dynamics=lambda y, u, interval, p: formula.step(y, u, interval, p)[0],
        cost=lambda y, u, interval, p, smoothing: formula.step(y, u, interval, p)[1],
        error_size=n + of.decided,
        control_size=b,
        terminal_cost=None if of.terminal_cost is None else terminal_cost,
        equality=None if of.path_equality is None else equality,
        inequality=inequality if of.path_inequality is not None or bounded_states else None,
        final_rows=None if of.terminal_equality is None else final_rows,
        final_inequality=(
            final_inequality if of.terminal_inequality is not None or bounded_end else None
        ),
        limits=None if of.control_bounds is None else limits,
        free_start=of.decided,
        linearisation=derivatives.linearisation,
        lagrangian_hessian=derivatives.lagrangian_hessian,
        moved=moved,
        flight=lambda y, u, interval, p, finer: formula.step(y, u, interval, p, finer)[0],
        layout=Layout(
            states=s,
            parameters=of.parameters,
            times=lambda y, p: of.final_time(y, p) * jnp.arange(count + 1) / count,
            controls=of.unscaled,
            scaled=lambda u, p: (u - of.scale(p)[0]) / of.scale(p)[1],
            bounds=(of.state_lower, of.state_upper),
            decided=_decided(of),
            free_time=of.duration is None,
            check=lambda p: check_parameters(of, p),
        ),
    )
    if of.retract is None:
        return programme
    return replace(programme, retract=retract, difference=difference)


def _within(values: Array, lower: Floats, upper: Floats) -> Array:
    """Margins to the bounds that are finite."""
    low, high = np.flatnonzero(np.isfinite(lower)), np.flatnonzero(np.isfinite(upper))
    return jnp.concatenate([values[low] - lower[low], upper[high] - values[high]])


def _within_time(final: Array, shortest: float, longest: float) -> Array:
    """Margins to the limits of the final time, of its logarithm: linear in what is decided."""
    rows = []
    if shortest > 0.0:
        rows.append(jnp.log(final) - np.log(shortest))
    if np.isfinite(longest):
        rows.append(np.log(longest) - jnp.log(final))
    return jnp.stack(rows) if rows else jnp.zeros((0,), final.dtype)


def _decided(of: Continuous) -> tuple[Floats, Floats]:
    """Bounds of the free parameters and of the logarithm of a free final time."""
    lower, upper = of.free_lower, of.free_upper
    if of.duration is None:
        shortest, longest = of.time_bounds
        least = np.log(shortest) if shortest > 0.0 else -np.inf
        lower, upper = np.append(lower, least), np.append(upper, np.log(longest))
    return lower, upper
