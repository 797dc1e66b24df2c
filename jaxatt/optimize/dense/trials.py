"""Third part of an iteration: evaluate trial points and choose the best."""

from __future__ import annotations

from typing import Any, NamedTuple

from jax import Array

from jaxatt.optimize.dense import arrays, proposals
from jaxatt.optimize.dense.active_set import Step, newton_step
from jaxatt.optimize.dense.arrays import certain, namespace, no, on_host
from jaxatt.optimize.dense.decide import Decision
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.state import State
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trust_region import spectrum_of

_LEAST_PENALTY = 1e-2
_NEARLY = 0.1
"""Largest relative error of the expected fall of the merit with which a step is taken alone."""


class _Points(NamedTuple):
    """Trial points.

    points : (k, n), None where a step on the first-order conditions is certain.  values : (k,), the
    merit there if it is known already.  expected : () fall of the merit with the Newton step, nan
    where that is not to be taken alone.  curved, uncertain : () bool, negative curvature here,
    perhaps negative.  newton : the step on the first-order conditions.  method : state of a
    first-order minimiser.
    """

    points: Array | None
    values: Array | None
    expected: Array
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
    never = xp.asarray(False)
    nowhere = Trial(s.x, never, never, s.radius, never, None, s.method)
    if certain(decision.stays & no(seen.finishing)):
        return nowhere
    if certain(no(decision.changed)):
        estimate, gradient = seen.estimate, seen.gradient
    else:
        estimate = merit.estimate(at.rows)
        gradient = merit.gradient(at, estimate)
    fixed = proposals.held(s.x, gradient, task.constraints)
    value = merit.value(at.objective, at.rows, estimate)
    if task.first_order is None:
        proposed = _second_order(task, s, seen, decision, estimate, gradient, fixed, value)
    else:
        proposed = _first_order(task, s, decision, gradient, fixed)
    if proposed.points is None:
        return nowhere._replace(newton=proposed.newton)
    points, values = proposed.points, proposed.values
    if values is None:
        points, values = _evaluated(task, s, seen, merit, fixed, value, proposed)
    best = xp.argmin(values)
    x, lowest = points[best], values[best]
    lowered = lowest < value - 1e-15 * xp.maximum(1.0, abs(value))
    if task.inner == "adam":
        lowered = xp.isfinite(lowest)
    length = xp.sqrt((x - s.x).dot(x - s.x))
    radius = xp.where(lowered, xp.maximum(2.0 * length, 0.1 * s.radius), 0.1 * s.radius)
    radius = xp.clip(radius, 1e-8 * xp.maximum(1.0, decision.size), 1e30)
    drop = value - lowest
    downhill = proposed.uncertain & (drop > 1e-7 * xp.maximum(1.0, abs(value)))
    return Trial(x, lowered, downhill, radius, proposed.curved, proposed.newton, proposed.method)


def _evaluated(
    task: Task,
    s: State,
    seen: Look,
    merit: Merit,
    fixed: Array,
    value: Array,
    proposed: _Points,
) -> tuple[Array, Array]:
    """All trial points (k, n) and the merit (k,) there, inf where they do not count.

    Directions without a reason serve only where nothing else tells a saddle.
    """
    xp, points = namespace(s.x), proposed.points
    assert points is not None
    if task.first_order is not None or certain(no(seen.finishing)):
        values = task.merits(points, merit)
    else:
        probes = proposals.probes(s.x, fixed, s.radius, task.constraints)
        reasoned = len(points)
        points = xp.concatenate([points, probes])
        counts = seen.finishing | (xp.arange(len(points)) < reasoned)
        values = xp.where(counts, task.merits(points, merit), xp.inf)
    if task.first_order is None and not on_host(values):
        # The host looks at the Newton step before there are others.
        first = _as_expected(value - values[proposals.NEWTON], proposed.expected)
        others = xp.arange(len(points)) != proposals.NEWTON
        values = xp.where(first & others, xp.inf, values)
    return points, values


def _as_expected(fall: Array, expected: Array) -> Array:
    """Whether the merit falls as the quadratic model says, so that nothing else need be tried."""
    return abs(fall - expected) <= _NEARLY * expected


def _second_order(
    task: Task,
    s: State,
    seen: Look,
    decision: Decision,
    estimate: Array,
    gradient: Array,
    fixed: Array,
    value: Array,
) -> _Points:
    xp, at, merit, multipliers = namespace(s.x), seen.at, decision.merit, decision.multipliers
    in_hessian = arrays.choose(decision.newton, multipliers, estimate)
    if task.inner == "gauss-newton":
        in_hessian = xp.zeros_like(in_hessian)
    hessian = task.hessian(s.x, merit.weight, in_hessian)
    binds = task.constraints.equal | (estimate < 0)
    (jacobian,) = arrays.rows_where(binds, at.jacobian)
    if merit.penalty.ndim == 0:
        full = hessian + merit.penalty * jacobian.T.dot(jacobian)
    else:
        (penalty,) = arrays.rows_where(binds, merit.penalty)
        full = hessian + (jacobian * penalty[:, None]).T.dot(jacobian)
    spectrum = spectrum_of(full, fixed)
    lowest = spectrum.values[0]
    steepest = xp.max(abs(xp.diag(full)), initial=1.0)
    curved = lowest < -1e-9 * steepest
    most = 1.0 / xp.max(merit.penalty, initial=_LEAST_PENALTY)
    if not certain(no(curved)):
        shift = xp.where(curved, -1.1 * lowest, 0.0)
        hessian = hessian + shift * xp.eye(s.x.shape[0], dtype=s.x.dtype)
    newton = newton_step(
        s.x,
        at,
        merit.weight,
        hessian,
        multipliers,
        xp.where(decision.newton, xp.clip(seen.total, 1e-10, most), most),
        task.constraints,
    )
    unknown, uncertain = xp.asarray(xp.nan), lowest <= 1e-7 * steepest
    if certain(decision.newton):
        return _Points(None, None, unknown, curved, uncertain, newton, s.method)
    move = newton.x - s.x
    expected = -move.dot(gradient + 0.5 * full.dot(move))
    # The first pass of every inner minimisation looks around.
    alone = (expected > 0) & (s.inner > 0) & no(curved | seen.finishing)
    expected = xp.where(alone, expected, xp.nan)
    if certain(alone):
        there = task.merit(newton.x, merit)
        if certain(_as_expected(value - there, expected)):
            points, values = newton.x[None], there[None]
            return _Points(points, values, expected, curved, uncertain, newton, s.method)
    points = proposals.second_order(
        s.x, gradient, spectrum, fixed, newton.x, s.radius, task.constraints
    )
    return _Points(points, None, expected, curved, uncertain, newton, s.method)


def _first_order(
    task: Task, s: State, decision: Decision, gradient: Array, fixed: Array
) -> _Points:
    assert task.first_order is not None
    fresh = decision.ended | decision.turned | decision.runaway | (s.inner == 0)
    points, method = task.first_order.propose(
        s.x, gradient, fixed, s.method, fresh, s.radius, task.constraints
    )
    never = namespace(s.x).asarray(False)
    return _Points(points, None, never, never, never, None, method)
