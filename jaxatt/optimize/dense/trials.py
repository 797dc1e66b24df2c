"""Third part of an iteration: evaluate trial points and choose the best."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense import proposals
from jaxatt.optimize.dense.active_set import Step, newton_step
from jaxatt.optimize.dense.decide import Decision
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.state import State
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trust_region import spectrum_of

_LEAST_PENALTY = 1e-2


class _Points(NamedTuple):
    """Trial points.

    points : (k, n).  reasoned : (k,) bool, those that are tried in every pass.

    curved, uncertain : () bool, negative curvature here, perhaps negative.  newton : the step on
    the first-order conditions.  method : state of a first-order minimiser.
    """

    points: Array
    reasoned: Array
    curved: Array
    uncertain: Array
    newton: Step | None
    method: Any


class Trial(NamedTuple):
    """The best trial point.

    x : (n,).  lowered : () bool, it lies below the current point.

    downhill : () bool, what looks stationary is none, this point lies clearly below.  radius : ()
    of the next pass.  curved, newton, method : as proposed.
    """

    x: Array
    lowered: Array
    downhill: Array
    radius: Array
    curved: Array
    newton: Step | None
    method: Any


def try_out(task: Task, s: State, seen: Look, decision: Decision) -> Trial:
    """Evaluate the merit at all trial points at once and choose the lowest."""
    at, merit = seen.at, decision.merit
    estimate = merit.estimate(at.rows)
    gradient = merit.gradient(at, estimate)
    fixed = proposals.held(s.x, gradient, task.box)
    if task.first_order is None:
        proposed = _second_order(task, s, seen, decision, estimate, gradient, fixed)
    else:
        proposed = _first_order(task, s, decision, gradient, fixed)
    value = merit.value(at.objective, at.rows)
    rows = jax.vmap(task.rows)(proposed.points)
    values = jax.vmap(lambda row: merit.value(row[0], row[1:]))(rows)
    # A row that is not finite may pass for one that holds: XLA's maximum drops it.
    finite = jnp.isfinite(jnp.concatenate([proposed.points, rows, values[:, None]], axis=1))
    # Directions without a reason serve only where nothing else tells a saddle.
    counts = jnp.all(finite, axis=1) & (proposed.reasoned | seen.finishing)
    values = jnp.where(counts, values, jnp.inf)
    best = jnp.argmin(values)
    x, lowest = proposed.points[best], values[best]
    lowered = lowest < value - 1e-15 * jnp.maximum(1.0, jnp.abs(value))
    if task.inner == "adam":
        lowered = jnp.isfinite(lowest)
    length = jnp.linalg.norm(x - s.x)
    radius = jnp.where(lowered, jnp.maximum(2.0 * length, 0.1 * s.radius), 0.1 * s.radius)
    radius = jnp.clip(radius, 1e-8 * jnp.maximum(1.0, decision.size), 1e30)
    drop = value - lowest
    downhill = proposed.uncertain & (drop > 1e-7 * jnp.maximum(1.0, jnp.abs(value)))
    return Trial(x, lowered, downhill, radius, proposed.curved, proposed.newton, proposed.method)


def _second_order(
    task: Task,
    s: State,
    seen: Look,
    decision: Decision,
    estimate: Array,
    gradient: Array,
    fixed: Array,
) -> _Points:
    at, merit, multipliers = seen.at, decision.merit, decision.multipliers
    n = s.x.shape[0]
    in_hessian = jnp.where(decision.newton, multipliers, estimate)
    if task.inner == "gauss-newton":
        in_hessian = jnp.zeros_like(in_hessian)
    hessian = task.hessian(s.x, merit.weight, in_hessian)
    binding = jnp.where(task.equal | (estimate < 0), merit.penalty, 0.0)
    full = hessian + at.jacobian.T @ (binding[:, None] * at.jacobian)
    spectrum = spectrum_of(full, ~fixed)
    lowest = spectrum.values[0]
    steepest = jnp.max(jnp.abs(jnp.diag(full)), initial=1.0)
    curved = lowest < -1e-9 * steepest
    shift = jnp.where(curved, -1.1 * lowest, 0.0)
    most = 1.0 / jnp.max(merit.penalty, initial=_LEAST_PENALTY)
    newton = newton_step(
        s.x,
        at,
        merit.weight,
        hessian + shift * jnp.eye(n, dtype=s.x.dtype),
        multipliers,
        jnp.where(decision.newton, jnp.clip(seen.total, 1e-10, most), most),
        task.box,
        task.equal,
    )
    points = proposals.second_order(s.x, gradient, spectrum, fixed, newton.x, s.radius, task.box)
    reasoned = jnp.arange(points.shape[0]) < points.shape[0] - proposals.PROBES
    return _Points(points, reasoned, curved, lowest <= 1e-7 * steepest, newton, s.method)


def _first_order(
    task: Task, s: State, decision: Decision, gradient: Array, fixed: Array
) -> _Points:
    assert task.first_order is not None
    fresh = decision.ended | decision.turned | decision.runaway | (s.inner == 0)
    points, method = task.first_order.propose(
        s.x, gradient, fixed, s.method, fresh, s.radius, task.box
    )
    no = jnp.asarray(False)
    return _Points(points, jnp.ones(points.shape[0], bool), no, no, None, method)
