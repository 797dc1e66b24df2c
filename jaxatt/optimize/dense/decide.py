"""Second part of an iteration: has the inner minimisation ended, and what is minimised next?"""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import certain, choose, namespace, no
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.residuals import largest
from jaxatt.optimize.dense.state import Phase, State
from jaxatt.optimize.dense.task import Task

_NEWTON_SHRINKS = 0.9
_LEAST_GOAL = 1e-11
_SHRINKS_WELL = 0.25
_GROWTH = 10.0
_LARGEST_PENALTY = 1e15
_LARGEST_MULTIPLIER = 1e10
_MOST_STALLS = 4
_MOST_RESTORATIONS = 3
_MOST_RESETS = 12
_PROBING_PENALTY = 1e7
_SETTLED = 8


class _Outer(NamedTuple):
    """Update of multipliers and penalty after the inner minimisation has `ended`.

    far : (), largest violation.  hopeless : () bool, it does not shrink.
    """

    ended: Array
    far: Array
    multipliers: Array
    penalty: Array
    goal: Array
    stalls: Array
    hopeless: Array


class _Restoration(NamedTuple):
    """Outcome of a restoration.

    () bool each.  restored : carry on with the programme.
    """

    restored: Array
    infeasible: Array
    gave_up: Array


class Decision(NamedTuple):
    """Decision on the rest of an iteration.

    merit : the function to be lowered.  All others are () but multipliers (q,).

    changed : the merit may be another one than that of the look.  multipliers : those of the
    augmented Lagrangian.  newton : a step on the first-order conditions comes next.
    failed : the one on trial was no good.  turned : a restoration begins or ends.
    runaway : the augmented Lagrangian fell without limit.  retreats : not all is finite.
    settles : residuals below tolerance fall no more.  near : constraints hold for the size of x.
    """

    merit: Merit
    changed: Array
    multipliers: Array
    penalty: Array
    goal: Array
    stalls: Array
    phase: Array
    ended: Array
    far: Array
    size: Array
    near: Array
    newton: Array
    failed: Array
    turned: Array
    hopeless: Array
    infeasible: Array
    gave_up: Array
    runaway: Array
    retreats: Array
    settles: Array

    @property
    def stays(self) -> Array:
        """Whether the next point is no trial point, unless only the curvature is looked at."""
        away = self.failed | self.runaway | self.retreats | self.settles
        return away | self.infeasible | self.gave_up


def decide(task: Task, s: State, seen: Look) -> Decision:
    """Decide from the current point what the next step is for."""
    xp = namespace(s.x)
    reach = largest(s.x - task.constraints.project(s.x - seen.gradient))
    most = xp.where(seen.restoring, 5 * task.limits.max_inner, task.limits.max_inner)
    exhausted = s.stuck | (s.inner >= most)
    outer = _update(task, s, seen, reach, exhausted)
    restoration = _restoration(task, s, seen, reach, exhausted)
    far, ended = outer.far, outer.ended
    hopeless = outer.hopeless & (s.restorations < _MOST_RESTORATIONS)

    # Where the augmented Lagrangian, not the programme, has no minimum: more penalty.
    size = largest(s.x)
    near = far <= task.limits.tolerance * xp.maximum(1.0, size)
    runaway = (far > 1e4 * xp.maximum(1.0, s.violation)) | ((size > 1e12) & no(near))
    descending = s.phase == Phase.DESCENT
    runaway = runaway & seen.finite & descending & no(near) & (s.resets < _MOST_RESETS)

    kept = seen.finite & seen.trying & (seen.total <= _NEWTON_SHRINKS * s.anchor.total)
    newton = ((ended & no(hopeless)) | kept) & no(seen.finishing)
    if task.first_order is not None:
        newton = newton & False
    phase = xp.where(newton, Phase.NEWTON, xp.where(seen.restoring, s.phase, Phase.DESCENT))
    phase = xp.where(hopeless, Phase.RESTORATION, phase)
    phase = xp.where(restoration.restored, Phase.DESCENT, phase)
    turned = hopeless | restoration.restored
    multipliers = choose(turned, xp.zeros_like(outer.multipliers), outer.multipliers)
    more = xp.minimum(100.0 * outer.penalty, _LARGEST_PENALTY)
    penalty = xp.where(runaway, more, outer.penalty)

    weight = xp.where(phase == Phase.RESTORATION, 0.0, 1.0)
    used = choose(phase == Phase.RESTORATION, task.own_penalty, penalty)
    used = choose(seen.finishing, xp.maximum(used, _PROBING_PENALTY), used)
    held = choose(seen.finishing, seen.here.multipliers, multipliers)
    return Decision(
        merit=Merit(weight, held, used, task.constraints.most),
        changed=ended | turned | runaway | seen.finishing | seen.trying,
        multipliers=multipliers,
        penalty=penalty,
        goal=outer.goal,
        stalls=outer.stalls,
        phase=phase,
        ended=ended,
        far=far,
        size=size,
        near=near,
        newton=newton,
        failed=seen.trying & no(kept) & no(seen.finishing),
        turned=turned,
        hopeless=hopeless,
        infeasible=restoration.infeasible,
        gave_up=restoration.gave_up,
        runaway=runaway,
        retreats=no(seen.finite) & no(seen.trying),
        settles=(s.settled >= _SETTLED) & no(seen.finishing),
    )


def _update(task: Task, s: State, seen: Look, reach: Array, exhausted: Array) -> _Outer:
    """New multipliers, penalty and goal after an inner minimisation has ended."""
    xp = namespace(s.x)
    error, tolerance = seen.here.residuals, task.limits.tolerance
    flat = (s.inner > 0) & (reach <= s.goal) & no(s.curved)
    descending = s.phase == Phase.DESCENT
    ended = seen.finite & descending & (flat | exhausted) & no(seen.finishing)
    far = largest(task.constraints.violated(seen.at.rows))
    well = (seen.met & (error.product <= tolerance)) | (far <= _SHRINKS_WELL * s.violation)
    steeper = xp.where(s.stalls >= _MOST_STALLS - 1, _GROWTH**2, _GROWTH)
    growth = xp.where(ended & no(well), steeper, 1.0)
    stalls = xp.where(ended, xp.where(well, 0, s.stalls + 1), s.stalls)
    goal = xp.maximum(_LEAST_GOAL, 0.1 * xp.minimum(s.goal, 10.0 * reach))
    return _Outer(
        ended=ended,
        far=far,
        multipliers=_updated(s, seen, ended),
        penalty=xp.minimum(s.penalty * growth, _LARGEST_PENALTY),
        goal=xp.where(ended, goal, s.goal),
        stalls=stalls,
        hopeless=ended & no(seen.met) & (stalls >= _MOST_STALLS) & (far > 0.5 * s.violation),
    )


def _updated(s: State, seen: Look, ended: Array) -> Array:
    """Multipliers of the augmented Lagrangian, the first-order estimates where it has `ended`."""
    if certain(no(ended)):
        return s.multipliers
    safe = namespace(s.x).clip(seen.estimate, -_LARGEST_MULTIPLIER, _LARGEST_MULTIPLIER)
    return choose(ended, safe, s.multipliers)


def _restoration(task: Task, s: State, seen: Look, reach: Array, exhausted: Array) -> _Restoration:
    """Whether a restoration has ended: back to the programme, or locally infeasible."""
    xp = namespace(s.x)
    if certain(no(seen.restoring)):
        return _Restoration(seen.restoring, seen.restoring, seen.restoring)
    violation = seen.here.residuals.violation
    own = 1.0 / task.scaling.rows[1:]
    amiss = xp.sqrt(xp.sum(task.constraints.violated(seen.at.rows * own) ** 2))
    spread = xp.maximum(1.0, largest(seen.at.jacobian * own[:, None]))
    level = reach <= 1e-9 * amiss * spread
    at_it = seen.finite & seen.restoring
    restored = at_it & (violation <= 0.1 * task.limits.tolerance)
    over = at_it & no(restored) & ((level & (s.inner > 0) & no(s.curved)) | exhausted)
    infeasible = over & no(seen.met) & (reach <= 1e-5 * amiss * spread)
    gave_up = over & no(seen.met) & no(infeasible) & (s.restorations >= _MOST_RESTORATIONS)
    return _Restoration(restored | (over & no(infeasible | gave_up)), infeasible, gave_up)
