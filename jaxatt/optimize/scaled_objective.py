"""Scale the objective of a programme by a factor that is part of its arguments."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import (
    Linearisation,
    OptimalControlProgram,
    lagrangian_hessian,
    linearisation,
)


class Scaled(NamedTuple):
    """Arguments of a scaled programme.

    args : of the programme itself.  factor : () of its objective.
    """

    args: Any
    factor: Array


def _inner(function: Callable[..., Any] | None) -> Callable[..., Any] | None:
    """The same function, whose last argument is `Scaled`."""
    if function is None:
        return None
    return lambda *given: function(*given[:-1], given[-1].args)


@functools.cache
def scaled_objective(program: OptimalControlProgram) -> OptimalControlProgram:
    """Programme of `Scaled` arguments with the objective times the factor."""

    def cost(x: Array, u: Array, stage: Any, scaled: Scaled, smoothing: Array) -> Array:
        return scaled.factor * program.cost(x, u, stage, scaled.args, smoothing)

    def curvature(x: Array, u: Array, stage: Any, scaled: Scaled, smoothing: Array) -> Array:
        return scaled.factor * program.cost_curvature(x, u, stage, scaled.args, smoothing)

    def terminal_cost(x: Array, scaled: Scaled) -> Array:
        return scaled.factor * program.final_cost(x, scaled.args)

    def moved(x: Array, u: Array, stage: Any, scaled: Scaled) -> tuple[Array, Array]:
        ahead, cost = program.next_and_cost(x, u, stage, scaled.args)
        return ahead, scaled.factor * cost

    def first(x: Array, u: Array, x_next: Array, stage: Any, scaled: Scaled) -> Linearisation:
        found = linearisation(program, x, u, x_next, stage, scaled.args)
        return found._replace(cost=scaled.factor * found.cost)

    def second(
        x: Array, u: Array, x_next: Array, stage: Any, scaled: Scaled, costate: Array, kept: Any
    ) -> Array:
        held = costate / scaled.factor
        found = lagrangian_hessian(program, x, u, x_next, stage, scaled.args, held, kept)
        return jnp.asarray(scaled.factor * found)

    def linearise(x: Array, u: Array, x_next: Array, stage: Any, scaled: Scaled) -> Array:
        return program.derivatives(x, u, x_next, stage, scaled.args)

    inner = {
        name: _inner(getattr(program, name))
        for name in (
            "start",
            "stages",
            "dynamics",
            "equality",
            "equality_weight",
            "inequality",
            "final_rows",
            "final_weight",
            "final_inequality",
            "free",
            "limits",
        )
    }
    changed: dict[str, Any] = {
        **inner,
        "cost": cost,
        "curvature": None if program.curvature is None else curvature,
        "terminal_cost": None if program.terminal_cost is None else terminal_cost,
        "linearisation": first,
        "lagrangian_hessian": second,
        "linearise": None if program.linearise is None else linearise,
        "moved": moved,
        "flight": None,
        "layout": None,
    }
    return replace(program, **changed)
