"""Tuning of gains by gradient descent on the figures of a flight, through the closed loop."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.control.feedback import FeedbackLaw
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.flight_build import build_flight
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.simulation.campaign import Start
from jaxatt.simulation.closed_loop import Flight, fly
from jaxatt.simulation.settling import Figures
from jaxatt.spacecraft.dynamics import AttitudeState

AIMS = ("settling", "integral")

_FIRST_STEP, _LAST_STEP = 0.2, 1e-4  # in logarithms of the gains
_PENALTY = 10.0


@dataclass(frozen=True, eq=False)
class Tuned:
    """Result of a tuning.

    law : with its new gains.  values : "settling" [s] of the slowest axis, "integral" [N m s] and
    "peak" [N m], before : those it began with.  history : (iterations, 3), the same in that order.
    gradient : of the aim with respect to the logarithms of the free gains, at the end.
    """

    law: FeedbackLaw
    before: Mapping[str, float]
    values: Mapping[str, float]
    history: Floats
    gradient: Floats
    flights: int


def tune(
    scenario: FlightScenario,
    law: str,
    free: Sequence[str],
    *,
    aim: str = "settling",
    peak_limit: float | None = None,
    integral_limit: float | None = None,
    iterations: int = 60,
) -> Tuned:
    """Lower the settling time (or the integrated torque) of the nominal run within torque limits.

    free : names of the gains that may change; those of vectors as "proportional.1".
    peak_limit : [N m], largest torque on any axis.  integral_limit : [N m s].

    Gains move in their logarithms, so that none changes sign.  Each step is the one along the
    gradient that keeps the linearised limits, in a region that shrinks where the flight disagrees:
    the settling time jumps where an overshoot touches the band, and there descent ends.

    Raises `ValueError` for an unknown aim or gain, or where the first flight does not settle.
    """
    if aim not in AIMS:
        raise ValueError(f"aim = {aim!r}: unknown; choose one of {', '.join(AIMS)}")
    first = scenario.laws[law]
    flight, start = build_flight(replace(scenario, noise=(0.0, 0.0)))
    gains = np.array([float(_gain(first, name)) for name in free])
    if not (gains > 0.0).all():
        raise ValueError(f"free = {list(free)}: gains {gains.tolist()} must be greater than 0")
    evaluate = _evaluator(flight, start, first, tuple(free), gains)
    limits = [peak_limit or np.inf, integral_limit or np.inf]

    def problem(x: Floats) -> tuple[Floats, float, Floats, Floats, Floats]:
        values, slopes = (np.asarray(part) for part in evaluate(jnp.asarray(x)))
        rows = [AIMS.index(aim), 2, 1]  # settling, integral, peak
        scaled, slope = values[rows], slopes[rows]
        bound = np.array([k / limit - 1.0 for k, limit in zip(scaled[1:], limits, strict=True)])
        normal = slope[1:] / np.array(limits)[:, None]
        return values, float(scaled[0]), slope[0], bound, normal

    x = np.zeros(len(free))
    values, value, gradient, bound, normal = problem(x)
    if not np.isfinite(value):
        raise ValueError(f"{scenario.name}, {law}: the first flight does not settle; start nearer")
    history, size, scale, flights = [values], _FIRST_STEP, abs(value), 1
    for _ in range(iterations):
        step = _step(gradient, bound, normal, size)
        trial = problem(x + step)
        flights += 1
        if _merit(trial[1], trial[3], scale) < _merit(value, bound, scale) - 1e-9:
            x = x + step
            values, value, gradient, bound, normal = trial
            history.append(values)
            size = min(1.5 * size, 0.5)
        else:
            size *= 0.5
        if size < _LAST_STEP:
            break
    return Tuned(
        _with_gains(first, tuple(free), jnp.asarray(gains * np.exp(x))),
        _named(history[0]),
        _named(values),
        np.asarray(history),
        gradient,
        flights,
    )


def _named(values: Floats) -> dict[str, float]:
    return dict(zip(("settling", "integral", "peak"), map(float, values), strict=True))


def _merit(value: float, bound: Floats, scale: float) -> float:
    if not np.isfinite(value):
        return np.inf
    return value / scale + _PENALTY * float(np.maximum(bound, 0.0).sum())


def _step(gradient: Floats, bound: Floats, normal: Floats, size: float) -> Floats:
    """Point within the linearised limits that is nearest to a gradient step of `size`."""
    wanted = -size * gradient / max(float(np.linalg.norm(gradient)), 1e-300)
    best, found = wanted, np.inf
    active = [i for i in range(len(bound)) if np.isfinite(bound[i]) and normal[i].any()]
    for count in range(len(active) + 1):
        for chosen in itertools.combinations(active, count):
            rows = list(chosen)
            a, b = normal[rows], -bound[rows]
            step = wanted - np.linalg.pinv(a) @ (a @ wanted - b) if rows else wanted
            if all(normal[i] @ step + bound[i] <= 1e-12 for i in active):
                away = float(np.linalg.norm(step - wanted))
                best, found = (step, away) if away < found else (best, found)
    length = float(np.linalg.norm(best))
    return best if length <= 2.0 * size else best * (2.0 * size / length)


def _gain(law: Any, name: str) -> Array:
    field, _, index = name.partition(".")
    if not hasattr(law, field):
        raise ValueError(f"free: {type(law).__name__} has no gain {field!r}")
    value = jnp.asarray(getattr(law, field))
    return value[int(index)] if index else value


def _with_gains(law: Any, names: tuple[str, ...], gains: Array) -> Any:
    for number, name in enumerate(names):
        field, _, index = name.partition(".")
        value = gains[number]
        if index:
            value = jnp.asarray(getattr(law, field)).at[int(index)].set(value)
        law = replace(law, **{field: value})
    return law


def _evaluator(
    flight: Flight, start: Start, law: FeedbackLaw, names: tuple[str, ...], gains: Floats
) -> Callable[[Array], tuple[Array, Array]]:
    """Function of the gains' logarithms: settling, integral, peak (3,) and their derivatives."""
    first = jax.tree.map(lambda leaf: leaf[0, 0], flight.nodes)
    begin = AttitudeState(
        jnp.asarray(start.q_ob),
        jnp.asarray(start.omega_ob) + first.rate.array,
        jnp.asarray(start.omega_bw),
    )

    def values(x: Array, shared: Flight, base: Array) -> tuple[Array, Array]:
        tuned = _with_gains(law, names, base * jnp.exp(x))
        figures: Figures = fly(shared, shared.nominal, begin, tuned, jax.random.key(0)).figures
        settling, peak = jnp.max(figures.settling[:3]), jnp.max(jnp.abs(figures.peak))
        both = jnp.stack([settling, figures.integral, peak])
        return both, both

    # Forward mode: few gains, and nothing of the long flight has to be kept.
    compiled = jax.jit(jax.jacfwd(values, has_aux=True))

    def evaluate(x: Array) -> tuple[Array, Array]:
        slopes, found = compiled(x, flight, jnp.asarray(gains))
        return found, slopes

    return evaluate
