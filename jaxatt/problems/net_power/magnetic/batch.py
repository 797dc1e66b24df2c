"""Solve of many starts, and their claims flown again with finer steps."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.program import magnetic_program, wanted
from jaxatt.problems.net_power.magnetic.starts import Starts
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.chunks import Progress, in_chunks
from jaxatt.runtime.settings import QUICK_TO_COMPILE

ROWS = 8
"""Starts in one compiled call on a CPU: more do not fit into the cache of a core."""
FINER = 10
"""Steps of a flight for each of the programme's."""
_SHARP = 1e-7
"""[rad] Width of the edges of the shadow in a flight."""


@dataclass(frozen=True)
class MagneticJob:
    """Static part of a solve, as `run_starts` needs it."""

    form: MagneticForm

    @property
    def label(self) -> str | None:
        """Label by which programs are kept between processes."""
        return f"net-power magnetic {self.form}"

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        return magnetic_program(self.form)

    def enter(
        self, start: Starts, parameters: MagneticParameters
    ) -> tuple[tuple[Array, Array], MagneticParameters]:
        """Initial controls and states for the solver, and the parameters of one start."""
        own = replace(
            parameters,
            reference=jnp.asarray(start.reference),
            time_weight=jnp.asarray(start.time_weight),
        )
        return (jnp.asarray(start.u), jnp.asarray(start.x)), own


def solve(
    form: MagneticForm,
    starts: Starts,
    parameters: MagneticParameters,
    settings: InteriorSettings,
    progress: Progress | None = None,
) -> InteriorSolution:
    """Solve from all starts and gather the results on the host."""
    rows = ROWS if jax.default_backend() == "cpu" else None
    found: InteriorSolution = run_starts(
        InteriorPoint(settings), MagneticJob(form), starts, parameters, rows=rows, progress=progress
    )
    return found


def kept_finite(starts: Starts, found: InteriorSolution) -> tuple[Flags, Floats, Floats]:
    """Which answers are numbers, (S,), and controls and states, those of the starts elsewhere."""
    finite = np.array(
        [
            bool(np.isfinite(u).all() and np.isfinite(x).all())
            for u, x in zip(found.u, found.x, strict=True)
        ]
    )
    rows = finite[:, None, None]
    u, x = np.where(rows, found.u, starts.u), np.where(rows, found.x, starts.x)
    return finite, np.asarray(u), np.asarray(x)


class Claims(NamedTuple):
    """What answers are worth, flown with finer steps and sharp edges of the shadow; (S,) each.

    mean_power : [W].  turned : 1 - |q' q_ref| at the end.  rate : squared error [rad^2/s^2].
    """

    mean_power: Array | Floats
    turned: Array | Floats
    rate: Array | Floats


def claims(form: MagneticForm, u: Floats, final: Floats, parameters: MagneticParameters) -> Claims:
    """Fly controls (S, N, 3) in final times (S,) [s]."""
    sharp = replace(parameters, shadow_width=jnp.asarray(_SHARP), scale=jnp.asarray(1.0))
    form = replace(form, mean_power=True)
    found = in_chunks(
        lambda chunk: _claimed(form, sharp, *chunk),
        (np.asarray(u), np.log(final)),
        rows=ROWS,
        key=("claims", form, u.shape[1:]),
    )
    return Claims(*found)


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def _claimed(form: MagneticForm, p: MagneticParameters, u: Array, final: Array) -> Claims:
    program = magnetic_program(replace(form, substeps=FINER * form.substeps))

    def one(u: Array, final: Array) -> Claims:
        def advance(x: Array, inputs: tuple[Array, Any]) -> tuple[Array, Array]:
            return program.next_and_cost(x, *inputs, p)

        begin = jnp.concatenate([p.start, final[None]])
        end, cost = lax.scan(advance, begin, (u, program.stages(p)))
        target, missed = wanted(end, p, form)
        return Claims(-jnp.sum(cost), 1.0 - jnp.abs(jnp.sum(end[:4] * target)), jnp.sum(missed**2))

    return jax.vmap(one)(u, final)


def own_power(form: MagneticForm, u: Floats, x: Floats, parameters: MagneticParameters) -> Floats:
    """Mean powers (S,) [W] of controls (S, N, 3) at the solver's own states (S, N + 1, 8)."""
    own = replace(parameters, scale=jnp.asarray(1.0))
    form = replace(form, mean_power=True)
    return np.asarray(
        in_chunks(
            lambda chunk: _own_power(form, own, *chunk),
            (np.asarray(u), np.asarray(x)),
            rows=ROWS,
            key=("own power", form, u.shape[1:]),
        )
    )


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def _own_power(form: MagneticForm, p: MagneticParameters, u: Array, x: Array) -> Array:
    program = magnetic_program(form)

    def one(u: Array, x: Array) -> Array:
        def cost(x: Array, u: Array, stage: Any) -> Array:
            return program.next_and_cost(x, u, stage, p)[1]

        return -jnp.sum(jax.vmap(cost)(x[:-1], u, program.stages(p)))

    return jax.vmap(one)(u, x)
