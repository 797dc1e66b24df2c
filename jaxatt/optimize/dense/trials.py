"""Third part of an iteration: evaluate trial points and choose the best."""

from __future__ import annotations

from typing import Any, NamedTuple

from jax import Array

from jaxatt.optimize.dense import proposals
from jaxatt.optimize.dense.active_set import Step, newton_step
from jaxatt.optimize.dense.arrays import certain, namespace
from jaxatt.optimize.dense.decide import Decision
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.state import State
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trust_region import spectrum_of

_LEAST_PENALTY = 1e-2


class _Points(NamedTuple):
    """Trial points.

    points : (k, n), None where a step on the first-order conditions is certain.
    reasoned : (k,) bool, those that are tried in every pass.
    curved, uncertain : () bool, negative curvature here, perhaps negative.  newton : the step on
    the first-order conditions.  method : state of a first-order minimiser.
    """

    points: Array | None
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
    xp, at, merit = namespace(s.x), seen.at, decision.merit
    no = xp.asarray(False)
    nowhere = Trial(s.x, no, no, s.radius, no, None, s.method)
    if certain(decision.stays & ~seen.finishing):
        return nowhere
    estimate = merit.estimate(at.rows)
    gradient = merit.gradient(at, estimate)
    fixed = proposals.held(s.x, gradient, task.box)
    if task.first_order is None:
        proposed = _second_order(task, s, seen, decision, estimate, gradient, fixed)
    else:
        proposed = _first_order(task, s, decision, gradient, fixed)
    if proposed.points is None:
        return nowhere._replace(newton=proposed.newton)
    rows = task.rows(proposed.points)
    value = merit.value(at.objective, at.rows)
    values = merit.value(rows[:, 0], rows[:, 1:])
    # A row that is not finite may pass for one that holds: XLA's maximum drops it.
    finite = xp.isfinite(values + xp.sum(rows, axis=1) + xp.sum(proposed.points, axis=1))
    # Directions without a reason serve only where nothing else tells a saddle.
    counts = finite & (proposed.reasoned | seen.finishing)
    values = xp.where(counts, values, xp.inf)
    best = xp.argmin(values)
    x, lowest = proposed.points[best], values[best]
    lowered = lowest < value - 1e-15 * xp.maximum(1.0, abs(value))
    if task.inner == "adam":
        lowered = xp.isfinite(lowest)
    length = xp.sqrt((x - s.x) @ (x - s.x))
    radius = xp.where(lowered, xp.maximum(2.0 * length, 0.1 * s.radius), 0.1 * s.radius)
    radius = xp.clip(radius, 1e-8 * xp.maximum(1.0, decision.size), 1e30)
    drop = value - lowest
    downhill = proposed.uncertain & (drop > 1e-7 * xp.maximum(1.0, abs(value)))
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
    xp, at, merit, multipliers = namespace(s.x), seen.at, decision.merit, decision.multipliers
    n = s.x.shape[0]
    in_hessian = xp.where(decision.newton, multipliers, estimate)
    if task.inner == "gauss-newton":
        in_hessian = xp.zeros_like(in_hessian)
    hessian = task.hessian(s.x, merit.weight, in_hessian)
    binding = xp.where(task.equal | (estimate < 0), merit.penalty, 0.0)
    full = hessian + at.jacobian.T @ (binding[:, None] * at.jacobian)
    spectrum = spectrum_of(full, ~fixed)
    lowest = spectrum.values[0]
    steepest = xp.max(abs(xp.diag(full)), initial=1.0)
    curved = lowest < -1e-9 * steepest
    shift = xp.where(curved, -1.1 * lowest, 0.0)
    most = 1.0 / xp.max(merit.penalty, initial=_LEAST_PENALTY)
    newton = newton_step(
        s.x,
        at,
        merit.weight,
        hessian + shift * xp.eye(n, dtype=s.x.dtype),
        multipliers,
        xp.where(decision.newton, xp.clip(seen.total, 1e-10, most), most),
        task.box,
        task.equal,
    )
    if certain(decision.newton):
        return _Points(None, curved, curved, curved, newton, s.method)
    points = proposals.second_order(s.x, gradient, spectrum, fixed, newton.x, s.radius, task.box)
    reasoned = xp.arange(points.shape[0]) < points.shape[0] - proposals.PROBES
    return _Points(points, reasoned, curved, lowest <= 1e-7 * steepest, newton, s.method)


def _first_order(
    task: Task, s: State, decision: Decision, gradient: Array, fixed: Array
) -> _Points:
    assert task.first_order is not None
    fresh = decision.ended | decision.turned | decision.runaway | (s.inner == 0)
    points, method = task.first_order.propose(
        s.x, gradient, fixed, s.method, fresh, s.radius, task.box
    )
    xp = namespace(s.x)
    no = xp.asarray(False)
    return _Points(points, xp.ones(points.shape[0], bool), no, no, None, method)
