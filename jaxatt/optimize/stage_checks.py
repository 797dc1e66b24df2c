"""Check that a programme over stages fits its arguments: shapes, limits and first values."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.manifold_check import check_manifold
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.parameter_checks import check_arrays
from jaxatt.runtime.settings import RUNS_ONCE


def check_stages(program: OptimalControlProgram, args: Any) -> None:
    """Raise ValueError for a wrong shape, or a value that is not finite at the first stage.

    A programme that was made from another form is first checked as that.
    """
    if program.control_size is None:
        raise ValueError(
            "control_size of the programme is None; the number of controls is expected"
        )
    check_arrays(args)
    if program.layout is not None:
        program.layout.check(args)
    x = jax.eval_shape(program.start, args)
    if len(x.shape) != 1:
        raise ValueError(f"start returns an array of shape {x.shape}; (states,) is expected")
    stages = jax.tree.leaves(jax.eval_shape(program.stages, args))
    counts = sorted({leaf.shape[:1] for leaf in stages})
    if len(counts) != 1 or counts[0] == ():
        raise ValueError(
            f"stages have leading axes {counts}; the same one, of N stages, is expected"
        )
    _check_first_stage(program, args, x.shape)
    if program.on_manifold and program.layout is None:
        start = program.start(args)
        check_manifold(program.retract, program.difference, start, program.error_size)


@functools.cache
def _evaluated(program: OptimalControlProgram) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """args -> everything at the first stage by name, as it is and compiled."""

    def everything(args: Any) -> dict[str, Array]:
        u = jnp.zeros(program.control_size or 0)
        x = program.start(args)
        stage = jax.tree.map(lambda leaf: leaf[0], program.stages(args))
        return {
            "dynamics": program.dynamics(x, u, stage, args),
            "cost": program.cost(x, u, stage, args, jnp.zeros(())),
            "terminal_cost": program.final_cost(x, args),
            "equality": program.equalities(x, u, stage, args),
            "inequality": program.inequalities(x, u, stage, args),
            "final_rows": program.final_equalities(x, args),
            "final_inequality": program.final_inequalities(x, args),
        }

    return everything, jax.jit(everything, compiler_options=RUNS_ONCE)


def _check_first_stage(program: OptimalControlProgram, args: Any, shape: tuple[int, ...]) -> None:
    evaluate, compiled = _evaluated(program)
    expected: dict[str, tuple[int, ...]] = {"dynamics": shape, "cost": (), "terminal_cost": ()}
    for name, found in jax.eval_shape(evaluate, args).items():
        fits = found.shape == expected[name] if name in expected else len(found.shape) == 1
        if not fits:
            wanted = expected.get(name, "(rows,)")
            raise ValueError(
                f"{name} returns an array of shape {found.shape}; {wanted} is expected"
            )
    for name, value in compiled(args).items():
        if not np.isfinite(np.asarray(value)).all():
            raise ValueError(
                f"{name} is {np.asarray(value)} at the first evaluation, of the first state with "
                "controls of zero; finite numbers are expected"
            )
