"""Answers of `minimize` and `solve_program` as differentiable functions of their parameters."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.minimize import Minimum
from jaxatt.multistart.programs.solution import ProgramSolution
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.inputs import box_of
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.model import Bounded
from jaxatt.optimize.interior_point.state import InteriorSettings
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.optimize.sensitivity.dense import (
    DenseArguments,
    DenseConditions,
    DenseLimits,
    DensePoint,
)
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.sensitivity.staged import StagedConditions, StagedPoint
from jaxatt.optimize.solver import refuse
from jaxatt.optimize.status import Status
from jaxatt.runtime.settings import check_precision

_USABLE = (Status.CONVERGED, Status.FEASIBLE)


def differentiable_minimum(
    minimum: Minimum,
    objective: Callable[..., Any],
    args: tuple[Any, ...] = (),
    *,
    equality: Callable[..., Any] | None = None,
    inequality: Callable[..., Any] | None = None,
    lower: Any = None,
    upper: Any = None,
    names: tuple[str, ...] = (),
) -> Optimum:
    """The answer of `jaxatt.minimize` as a differentiable function of `args`.

    The other arguments are those of the call of `minimize`.  The result is called with `args`; its
    variables are "x", (n,).  Its `sensitivities` are also by the finite bounds.
    names : of the inequalities, then of the lower and the upper bounds, for messages.

    Raises ValueError where the minimum met no constraints, or does not fit the functions.
    """
    check_precision()
    _usable(minimum.status)
    args = args if isinstance(args, tuple) else (args,)
    n = len(minimum.x)
    box = box_of(lower, upper, n)
    whole = DenseArguments(jax.tree.map(jnp.asarray, args), box)
    functions, own = Functions(objective, equality, inequality), minimum.multipliers
    counts = functions.counts(jnp.asarray(minimum.x), whole.args)
    found = (len(own.equality), len(own.inequality))
    if counts != found:
        raise ValueError(
            f"minimum has {found[0]} equalities and {found[1]} inequalities, the functions "
            f"{counts[0]} and {counts[1]}; pass what `minimize` was called with"
        )
    limits = DenseLimits(*map(jnp.asarray, (own.inequality, own.lower, own.upper)))
    near = DensePoint(jnp.asarray(minimum.x), jnp.asarray(own.equality), limits)
    answer = answer_at(DenseConditions(functions, names), whole, near)

    def enter(args: Any) -> DenseArguments:
        return DenseArguments(args if isinstance(args, tuple) else (args,), box)

    return Optimum(answer, _x, enter)


def _x(point: DensePoint, args: Any) -> Mapping[str, Array]:
    return {"x": point.x}


def differentiable_program(
    program: OptimalControlProgram, solution: ProgramSolution, parameters: Any = ()
) -> Optimum:
    """The answer of `jaxatt.solve_program` as a differentiable function of `parameters`.

    The result is called with parameters; its variables are "states" (N + 1, s), "controls" (N, b),
    "final_time" () and "free_parameters" (m,), as in the solution.

    Raises ValueError where the solution met no constraints, or is not one of the programme.
    """
    check_precision()
    _usable(solution.status)
    refuse(InteriorPoint(InteriorSettings()), program)
    args = jax.tree.map(jnp.asarray, parameters)
    near = _point_of(program, solution, args)
    return Optimum(answer_at(StagedConditions(program), args, near), _reader(program))


def _point_of(program: OptimalControlProgram, solution: ProgramSolution, args: Any) -> StagedPoint:
    """The point of a solution, in the coordinates of the stages."""
    layout, own = program.layout, solution.multipliers
    x, u, per_control = solution.states, jnp.asarray(solution.controls), np.ones(())
    if layout is not None:
        decided = solution.free_parameters
        if layout.free_time:
            decided = np.append(decided, np.log(solution.final_time))
        x = np.concatenate([x, np.broadcast_to(decided, (len(x), len(decided)))], axis=1)
        flat = jnp.zeros(u.shape[1])
        per_control = np.asarray(layout.controls(flat + 1.0, args) - layout.controls(flat, args))
        u = jax.vmap(layout.scaled, in_axes=(0, None))(u, args)
    start = program.start(args)
    if x.shape[1:] != start.shape:
        raise ValueError(
            f"solution has {x.shape[1]} states at a node, the programme {start.shape[0]}; pass the "
            "programme that was solved"
        )
    missed = np.asarray(program.difference(jnp.asarray(x[0]), start))
    return StagedPoint(
        jnp.asarray(missed[program.error_size - program.free_start :]),
        jnp.asarray(x[1:]),
        u,
        jnp.zeros((len(u), program.error_size)),
        jnp.asarray(own.path_equality),
        jnp.asarray(own.terminal_equality),
        Bounded(
            jnp.asarray(own.path_inequality),
            jnp.asarray(own.terminal_inequality),
            jnp.asarray(own.control_lower * per_control),
            jnp.asarray(own.control_upper * per_control),
        ),
    )


@functools.cache
def _reader(program: OptimalControlProgram) -> Callable[[StagedPoint, Any], Mapping[str, Array]]:
    conditions, layout = StagedConditions(program), program.layout

    def read(point: StagedPoint, args: Any) -> Mapping[str, Array]:
        x = jnp.concatenate([conditions.first(point, args)[None], point.x])
        if layout is None:
            return {"states": x, "controls": point.u}
        return {
            "states": x[:, : layout.states],
            "controls": jax.vmap(layout.controls, in_axes=(0, None))(point.u, args),
            "final_time": layout.times(x[0], args)[-1],
            "free_parameters": x[0, layout.states :][: layout.parameters],
        }

    return read


def _usable(status: Status) -> None:
    if status not in _USABLE:
        raise ValueError(
            f"status is {status.name}: only an answer that meets its constraints has "
            "sensitivities; solve again from more starts"
        )
