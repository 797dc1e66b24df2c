"""Solve a user's own optimal-control problem from many starts, and fly the best answer."""

from __future__ import annotations

import functools
import time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.multistart.programs.batch import solve_starts
from jaxatt.multistart.programs.solution import (
    FinerFlight,
    ProgramMultipliers,
    ProgramSolution,
    ProgramStartsRecord,
)
from jaxatt.multistart.programs.starts import Guess, draw_starts, limits_along, typical_cost
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings
from jaxatt.optimize.interior_point.state import SMALL_SHIFTS
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.scaled_objective import Scaled, scaled_objective
from jaxatt.optimize.solver import refuse
from jaxatt.optimize.stage_checks import check_stages
from jaxatt.optimize.status import Status
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Progress
from jaxatt.runtime.clock import compile_seconds
from jaxatt.runtime.settings import QUICK_TO_COMPILE, check_precision

_USUAL = (0.1, 1000.0)
"""Sizes of an objective that the solver's settings fit; others are scaled."""
_BARRIER = 0.1
"""The first one, of objectives of those sizes."""
_RENEWALS = 3
"""Of a start that is stuck."""
_SAME = 1e-6
"""Relative difference between objectives of one minimum."""


def solve_program(
    program: OptimalControlProgram,
    parameters: Any = (),
    *,
    starts: int = 16,
    seed: int = 0,
    controls: Any = None,
    states: Any = None,
    final_time: Any = None,
    tolerance: float = 1e-8,
    max_iterations: int = 300,
    finer: int = 10,
    progress: Progress | None = None,
) -> ProgramSolution:
    """Minimise the objective of an optimal-control programme from many starts at once.

    program : from `jaxatt.transcribe`, or written in stages.  Pass the same object again and
    nothing is compiled again.
    parameters : pytree of arrays, the last argument of the programme's functions.
    starts : how many; seed : of the random ones.  Start i depends on seed and i alone.
    controls, states, final_time : guesses for the first starts, (N, b), (N + 1, s) and (), or with
    one more leading axis for several; states that are not given are flown.
    tolerance : of violation, scaled stationarity and complementarity.
    max_iterations : passes of one start.
    finer : how many times as many integration steps the flight of the answer makes.
    progress : called with the number of starts that have just ended.

    The best start is returned: converged before feasible before anything else, then by objective.
    `Status.CONVERGED` means that violation and stationarity hold at the returned point.

    Raises ValueError where the programme has what the solver does not support, or its input does
    not make sense.
    """
    check_precision()
    for name, value in (("starts", starts), ("max_iterations", max_iterations), ("finer", finer)):
        if int(value) != value or value < 1:
            raise ValueError(f"{name} is {value!r}; a whole number from 1 on is expected")
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance is {tolerance!r}; a number between 0 and 1 is expected")
    refuse(InteriorPoint(InteriorSettings()), program)
    compiled, began = compile_seconds(), time.perf_counter()
    check_stages(program, parameters)
    args = jax.tree.map(jnp.asarray, parameters)
    guess = _guess(program, args, controls, states, final_time)
    drawn = draw_starts(program, args, starts, seed, guess)
    typical = typical_cost(program, drawn, args)
    factor = 1.0 if _USUAL[0] <= typical <= _USUAL[1] else 1.0 / typical
    settings = InteriorSettings(
        tolerance=tolerance,
        max_iterations=max_iterations,
        barrier=_BARRIER,
        shifts=SMALL_SHIFTS,
        renewals=_RENEWALS,
    )
    scaled = Scaled(args, jnp.asarray(factor))
    found = solve_starts(scaled_objective(program), drawn, scaled, settings, progress)
    best = _best(found)
    flight = _flight(program, found, best, args, finer)
    compiling = compile_seconds() - compiled
    running = time.perf_counter() - began - compiling
    return _answer(program, args, found, best, factor, flight, (compiling, running))


def _guess(
    program: OptimalControlProgram, args: Any, controls: Any, states: Any, final_time: Any
) -> Guess:
    """Guesses with a leading axis, with the controls in units of the stages."""
    layout = program.layout
    lower, _ = limits_along(program, args)
    count, size = lower.shape
    width = program.start(args).shape[0] if layout is None else layout.states
    u = _several("controls", controls, (count, size))
    x = _several("states", states, (count + 1, width))
    final = _several("final_time", final_time, ())
    if final is not None and (layout is None or not layout.free_time):
        raise ValueError("final_time is guessed, but the programme has no free final time")
    if final is not None and not (final > 0.0).all():
        raise ValueError(f"final_time is {final_time!r}; positive numbers [s] are expected")
    if u is not None and layout is not None:
        scaled = jax.vmap(layout.scaled, in_axes=(0, None))
        u = np.asarray(scaled(jnp.asarray(u.reshape(-1, size)), args)).reshape(u.shape)
    return Guess(u, x, final)


def _several(name: str, value: Any, shape: tuple[int, ...]) -> Floats | None:
    if value is None:
        return None
    found = np.asarray(value, float)
    if found.shape == shape:
        found = found[None]
    if found.shape[1:] != shape or not len(found):
        raise ValueError(
            f"{name} has shape {np.shape(value)}; {shape} or (guesses, *{shape}) is expected"
        )
    if not np.isfinite(found).all():
        raise ValueError(f"{name} has entries that are not finite; numbers are expected")
    return found


_PREFERENCE = {
    Status.CONVERGED: 0,
    Status.FEASIBLE: 1,
    Status.UNBOUNDED: 2,
    Status.INFEASIBLE: 2,
    Status.ITERATION_LIMIT: 2,
    Status.NOT_FINITE: 3,
}


def _best(found: Any) -> int:
    """Index of the best start: converged, then feasible, by objective; else the least violation."""
    rank = np.array([_PREFERENCE[Status(int(s))] for s in found.status])
    value = np.where(rank <= 1, found.objective, found.violation)
    return int(np.lexsort([np.nan_to_num(value, nan=np.inf), rank])[0])


@functools.partial(jax.jit, static_argnames=("program", "finer"), compiler_options=QUICK_TO_COMPILE)
def _flown_finer(
    program: OptimalControlProgram, first: Array, u: Array, last: Array, args: Any, finer: int
) -> tuple[Array, Array, Array]:
    """States at all nodes, error of the last one, and largest violation of terminal rows."""

    def advance(x: Array, inputs: tuple[Array, Any]) -> tuple[Array, Array]:
        row, stage = inputs
        if program.flight is None:
            return program.dynamics(x, row, stage, args), x
        return program.flight(x, row, stage, args, finer), x

    end, nodes = lax.scan(advance, first, (u, program.stages(args)))
    missed = jnp.max(jnp.abs(program.final_equalities(end, args)), initial=0.0)
    short = jnp.max(-program.final_inequalities(end, args), initial=0.0)
    error = jnp.max(jnp.abs(program.difference(end, last)))
    return jnp.concatenate([nodes, end[None]]), error, jnp.maximum(missed, short)


def _flight(
    program: OptimalControlProgram, found: Any, best: int, args: Any, finer: int
) -> FinerFlight:
    x, u = jnp.asarray(found.x[best]), jnp.asarray(found.u[best])
    states, error, missed = _flown_finer(program, x[0], u, x[-1], args, finer)
    own = states.shape[1] if program.layout is None else program.layout.states
    factor = 0 if program.flight is None else finer
    return FinerFlight(factor, np.asarray(states)[:, :own], float(error), float(missed))


def _minima(found: Any, factor: float) -> tuple[tuple[float, int], ...]:
    """Objectives of distinct minima among converged starts, and their counts, best first."""
    costs = np.sort(found.objective[found.status == Status.CONVERGED] / factor)
    groups: list[list[float]] = []
    for cost in costs:
        if groups and cost - groups[-1][0] <= _SAME * max(abs(cost), 1.0 / factor):
            groups[-1].append(float(cost))
        else:
            groups.append([float(cost)])
    return tuple((group[0], len(group)) for group in groups)


def _answer(
    program: OptimalControlProgram,
    args: Any,
    found: Any,
    best: int,
    factor: float,
    flight: FinerFlight,
    seconds: tuple[float, float],
) -> ProgramSolution:
    """Result in the user's units."""
    layout, x, u = program.layout, found.x[best], found.u[best]
    per_control: Floats | float = 1.0
    if layout is None:
        times, ends = np.arange(len(x), dtype=float), np.full(len(found.x), float(len(u)))
        own, free = x, x[0, :0]
    else:
        times = np.asarray(layout.times(jnp.asarray(x[0]), args))
        ends = np.array([float(layout.times(jnp.asarray(y), args)[-1]) for y in found.x[:, 0]])
        own, free = x[:, : layout.states], x[0, layout.states :][: layout.parameters]
        flat = jnp.zeros(u.shape[1])
        middle, high = (np.asarray(layout.controls(v, args)) for v in (flat, flat + 1.0))
        u = np.asarray(jax.vmap(layout.controls, in_axes=(0, None))(jnp.asarray(u), args))
        per_control = high - middle
    dual = jax.tree.map(lambda leaf: leaf[best] / factor, found.dual)
    multipliers = ProgramMultipliers(
        found.equality[best] / factor,
        dual.path,
        found.rows[best] / factor,
        dual.final,
        dual.lower / per_control,
        dual.upper / per_control,
    )
    record = ProgramStartsRecord(
        found.status.astype(int),
        found.objective / factor,
        found.violation,
        found.stationarity,
        found.iterations.astype(int),
        ends,
    )
    return ProgramSolution(
        Status(int(found.status[best])),
        float(found.objective[best] / factor),
        float(found.violation[best]),
        float(found.stationarity[best]),
        int(found.iterations[best]),
        times,
        own,
        u,
        float(times[-1]),
        free,
        multipliers,
        flight,
        _minima(found, factor),
        record,
        *seconds,
    )
