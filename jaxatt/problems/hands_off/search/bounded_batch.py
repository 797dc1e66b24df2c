"""Decide and settle supports of controls with limits of their own, many starts at once."""

from __future__ import annotations

import functools
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.reweighting.bounded import (
    BoundedReweighting,
    BoundedRoot,
    sparsify_bounded,
)
from jaxatt.optimize.reweighting.condensed import Reweighting, SparseRoot
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.batch import Form, Lanes
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate
from jaxatt.problems.hands_off.sparse_program import SparseArguments
from jaxatt.problems.hands_off.task import Task
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import CHUNK, Progress, in_chunks

DECIDE = BoundedReweighting()
"""Reweighting that decides supports, from scaled controls of any size."""

DECIDE_SLOWLY = BoundedReweighting(deciding=24, factor=0.75)
"""The same where path constraints, which are worst now here, now there, have to be met as well."""

SETTLE = BoundedReweighting(deciding=0, settling=20, settled_smoothing=1e-2)
"""Whether a given support leads to the target."""

POLISH = BoundedReweighting(deciding=0, settling=40, settled_smoothing=1e-4)
"""The least effort on a given support, to the full tolerance."""

_STILL = 1e-4
"""Largest change of a scaled control in the last step that counts as none."""

_TIGHT = 1e-7
"""Rows before the last step up to which a polished answer can be called converged."""


@functools.partial(jax.jit, static_argnames=("form",))
def _bounded_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, settings: BoundedReweighting
) -> BoundedRoot:
    respond, bounds = form.system.response, form.system.bounds
    assert respond is not None and bounds is not None
    lanes = jax.tree.map(jnp.asarray, lanes)

    def one(u: Array, sign: Array) -> tuple[Array, Array]:
        plant = form.system.turned(arguments.plant, sign)
        rows, derivatives = respond(u, plant)
        if form.system.path is not None:
            path, slopes = form.system.path(u, plant)
            rows = jnp.concatenate([rows, path])
            derivatives = jnp.concatenate([derivatives, slopes], axis=1)
        return rows, jnp.swapaxes(derivatives, 0, 1)

    def response(u: Array) -> tuple[Array, Array]:
        # The batch axis goes last, where every component becomes one contiguous vector.
        return jax.vmap(one, in_axes=(-1, 0), out_axes=0)(jnp.moveaxis(u, 0, -1), lanes.sign)

    lower, upper = bounds(arguments.plant)
    return sparsify_bounded(
        response,
        lower,
        upper,
        lanes.u,
        lanes.free,
        arguments.weight * arguments.count_scale,
        lanes.row_weight,
        settings,
    )


def sparsify_bounded_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    settings: BoundedReweighting,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> BoundedRoot:
    """As `batch.sparsify_lanes`, between bounds."""
    run = functools.partial(_bounded_chunk, form)
    key = ("sparsify bounded", form, lanes.u.shape[1:])
    return in_chunks(lambda chunk: run(chunk, arguments, settings), lanes, rows, progress, key)


def reweight_bounded(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    settings: Reweighting,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> SparseRoot:
    """What `polish.reweight` does, for a task whose system has bounds.

    settings : only whether the support is decided or given is read from them.
    """
    decide = DECIDE if form.system.path is None else DECIDE_SLOWLY
    chosen = decide if settings.deciding else SETTLE
    found = sparsify_bounded_lanes(form, lanes, arguments, chosen, progress, rows)
    # Bounds hold at every step, so there is no start that saturation could have led astray.
    return SparseRoot(found.u, found.support, found.residual, jnp.zeros(len(lanes.u), bool))


def polish_bounded(
    task: Task,
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> Candidates:
    """The least effort on the lanes' supports, or the least printed cost, flown and judged.

    Where the printed cost is minimised, the answer with every control on its nearer limit stands
    in for a start where it costs less: the cost punishes partly open thrusters.
    """
    soft = task.goal.terminal == "penalty"
    settings = replace(POLISH, effort=task.effort_weight if soft else 1.0)
    found = sparsify_bounded_lanes(form, lanes, arguments, settings, progress, rows)
    arrived = np.asarray(found.residual) <= _TIGHT
    still = np.asarray(found.moved) <= _STILL
    status = np.where(
        arrived & still,
        int(Status.CONVERGED),
        np.where(arrived, int(Status.FEASIBLE), int(Status.ITERATION_LIMIT)),
    )
    steps = np.full(len(lanes.u), POLISH.settling)
    settled = evaluate(task, np.asarray(found.u), status, steps, np.asarray(lanes.sign))
    if not soft:
        return settled
    lower, upper = (np.asarray(b) for b in bounds_of(task))
    snapped = _snapped(np.nan_to_num(np.asarray(found.u)), lower, upper)
    feasible = np.full(len(lanes.u), int(Status.FEASIBLE))
    whole = evaluate(task, snapped, feasible, steps, np.asarray(lanes.sign))
    cheaper = whole.rank[:, 0] < settled.rank[:, 0]
    return settled.where(~cheaper, whole)


def bounds_of(task: Task) -> tuple[Array, Array]:
    """Limits (b,) of a task's scaled controls."""
    bounds = task.system.bounds
    assert bounds is not None
    return bounds(task.arguments.plant)


def _snapped(u: Floats, lower: Floats, upper: Floats) -> Floats:
    """Every control on the nearest of zero and its limits."""
    levels = np.stack(np.broadcast_arrays(np.zeros_like(u), lower, upper))
    nearest = np.abs(levels - u).argmin(axis=0)
    return np.asarray(np.take_along_axis(levels, nearest[None], axis=0)[0])
