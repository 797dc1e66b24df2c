"""Run starts one after the other with the loop of the solver on the host.

Only the functions of the programme are compiled, which takes a fraction of the time that the whole
loop takes; every pass then costs some calls from Python.
"""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from jaxatt.optimize.dense.called import CalledFunctions
from jaxatt.optimize.dense.solver import Case, DenseLagrangian
from jaxatt.optimize.dense.start import Draws
from jaxatt.optimize.solver import refuse
from jaxatt.runtime.processes import shared


def run_on_host(
    solver: DenseLagrangian, program: CalledFunctions, starts: Draws, args: Case
) -> Any:
    """As `driver.run_starts`, without compiling the solver; starts : leading axis S."""
    refuse(solver, program)
    device = _processor()
    args = args._replace(values=jax.device_put(args.values, device))

    def own(some: Draws, _: Any) -> Any:
        with jax.default_device(device), np.errstate(all="ignore"):
            ends = [solver.run(program, Draws(*one), args) for one in zip(*some, strict=True)]
        return jax.tree.map(lambda *leaves: np.array(leaves), *ends)

    return shared(own, starts, None)


def _processor() -> Any:
    """The device for functions that are called one by one, where an accelerator would only wait."""
    if jax.default_backend() == "cpu":
        return None
    try:
        return jax.local_devices(backend="cpu")[0]
    except RuntimeError:  # JAX was told to leave it out
        return None
