"""Whether a programme over stages fits its arguments: shapes, limits and first values."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.parameter_checks import check_arrays
from jaxatt.runtime.settings import RUNS_ONCE


def check_stages(program: OptimalControlProgram, args: Any) -> None:
    """Raise ValueError where something has the wrong shape, or is not a number at the first stage.

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


def _check_first_stage(program: OptimalControlProgram, args: Any, shape: tuple[int, ...]) -> None:
    u = jnp.zeros(program.control_size)

    def everything(args: Any) -> dict[str, Any]:
        x = program.start(args)
        stage = jax.tree.map(lambda leaf: leaf[0], program.stages(args))
        return {
            "dynamics": program.dynamics(x, u, stage, args),
            "cost": program.cost(x, u, stage, args, jnp.zeros(())),
            "terminal_cost": program.final_cost(x, args),
            "difference": program.difference(x, x),
            "retract": program.retract(x, jnp.zeros(program.error_size)),
            "equality": program.equalities(x, u, stage, args),
            "inequality": program.inequalities(x, u, stage, args),
            "final_rows": program.final_equalities(x, args),
            "final_inequality": program.final_inequalities(x, args),
        }

    expected = {
        "dynamics": shape,
        "cost": (),
        "terminal_cost": (),
        "difference": (program.error_size,),
        "retract": shape,
    }
    shapes = {name: found.shape for name, found in jax.eval_shape(everything, args).items()}
    for name, found in shapes.items():
        fits = found == expected[name] if name in expected else len(found) == 1
        if not fits:
            wanted = expected.get(name, "(rows,)")
            raise ValueError(f"{name} returns an array of shape {found}; {wanted} is expected")
    for name, value in jax.jit(everything, compiler_options=RUNS_ONCE)(args).items():
        if not np.isfinite(np.asarray(value)).all():
            raise ValueError(
                f"{name} is {np.asarray(value)} at the first evaluation, of the first state with "
                "controls of zero; finite numbers are expected"
            )
