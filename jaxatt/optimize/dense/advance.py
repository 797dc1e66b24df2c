"""Last part of an iteration: end, or move to the next point."""

from __future__ import annotations

from jax import Array

from jaxatt.optimize.dense.arrays import certain, choose, namespace, no
from jaxatt.optimize.dense.decide import Decision
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.state import FIRST_GOAL, RUNNING, Anchor, Phase, State
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trials import Trial
from jaxatt.optimize.status import Status

_MOST_ESCAPES = 5
_MOST_RETREATS = 60
_BOTTOMLESS = -1e14
_FAR_AWAY = 1e10


def advance(task: Task, s: State, seen: Look, decision: Decision, trial: Trial) -> State:
    """State at the start of the next iteration."""
    xp = namespace(s.x)
    escape, worse = _saddle(task, s, seen, trial)
    status = _status(s, seen, decision, seen.finishing & no(escape))

    # By rising precedence.  A failed trial of Newton steps goes back to where it began.
    failed, runaway = decision.failed, decision.runaway
    # Settled below tolerance: end at the best point, after a last look at its curvature.
    retreats, settles = decision.retreats, decision.settles
    ends = status != RUNNING
    stays = failed | runaway | retreats | settles | ends
    retreats, settles = retreats & no(settles | ends), settles & no(ends)
    runaway = runaway & no(retreats | settles | ends)
    failed = failed & no(runaway | retreats | settles | ends)
    result = s
    if not certain(stays):
        result = choose(stays, s, _moved(s, seen, decision, trial, escape, worse))
    anew = failed | runaway
    x = choose(failed, s.anchor.x, choose(runaway, s.outer, result.x))
    x = choose(retreats, 0.5 * (s.safe + s.x), x)
    multipliers = choose(failed, s.anchor.multipliers, result.multipliers)
    radius = xp.where(runaway, 1.0, xp.where(retreats, 0.25 * s.radius, result.radius))
    phase = xp.where(failed, Phase.DESCENT, result.phase)
    return result._replace(
        x=choose(settles, s.stationary.x, x),
        safe=choose(failed, s.anchor.x, result.safe),
        multipliers=choose(settles, s.stationary.multipliers, multipliers),
        penalty=xp.where(runaway, decision.penalty, result.penalty),
        radius=radius,
        phase=xp.where(settles, Phase.NEWTON, phase),
        inner=xp.where(anew, 0, result.inner),
        stuck=result.stuck & no(anew),
        curved=result.curved & no(failed),
        resets=result.resets + runaway,
        retreats=result.retreats + retreats,
        finishing=result.finishing | settles,
        # The point that is stationary for the violation, rather than that of the least maximum.
        closest=choose(decision.infeasible, seen.here, result.closest),
        status=status,
        iterations=s.iterations + 1,
    )


def _saddle(task: Task, s: State, seen: Look, trial: Trial) -> tuple[Array, Array]:
    """Whether to move on from a stationary point, and whether a better feasible one is known."""
    xp, here = namespace(s.x), seen.here
    if certain(no(seen.finishing)):
        return seen.finishing, seen.finishing
    room = 1e-5 * xp.maximum(1.0, abs(here.objective))
    room = room + 2.0 * task.limits.tolerance * xp.sum(abs(here.residuals.multipliers))
    worse = s.feasible.objective < here.objective - room
    escape = seen.finishing & (trial.downhill | worse) & (s.escapes < _MOST_ESCAPES)
    return escape, worse


def _status(s: State, seen: Look, decision: Decision, converged: Array) -> Array:
    xp, near = namespace(s.x), decision.near
    status = xp.where(converged, Status.CONVERGED, RUNNING)
    status = xp.where(decision.infeasible, Status.INFEASIBLE, status)
    status = xp.where(decision.gave_up, Status.ITERATION_LIMIT, status)
    # A slope that fades far away from everything is no minimum either: -log(x).
    beyond = near & (decision.size > _FAR_AWAY)
    bottomless = seen.finite & near & no(seen.restoring) & (seen.at.objective < _BOTTOMLESS)
    status = xp.where(bottomless | (converged & beyond), Status.UNBOUNDED, status)
    return xp.where(s.retreats >= _MOST_RETREATS, Status.NOT_FINITE, status)


def _moved(
    s: State, seen: Look, decision: Decision, trial: Trial, escape: Array, worse: Array
) -> State:
    """State after an ordinary iteration: at the best trial point, or at a step to be tried."""
    xp = namespace(s.x)
    turned, newton = decision.turned, decision.newton
    restart = decision.ended | turned | decision.runaway | escape
    x = choose(trial.lowered | escape, trial.x, s.x)
    multipliers = decision.merit.multipliers
    if trial.newton is not None:
        steps = newton & no(escape)
        x = choose(steps, trial.newton.x, x)
        multipliers = choose(steps, trial.newton.multipliers, multipliers)
    penalty = decision.penalty
    if not certain(no(escape)):
        # The best feasible point seen is no worse than the saddle or maximum that this one is.
        better = escape & worse
        x = choose(better, s.feasible.x, x)
        penalty = xp.where(better, xp.maximum(10.0 * penalty, 100.0), penalty)
    phase = xp.where(escape, Phase.DESCENT, decision.phase)
    stationary = s.stationary
    if not certain(no(escape)):
        known = stationary.residuals
        forgotten = known._replace(total=xp.where(escape, xp.inf, known.total))
        stationary = stationary._replace(residuals=forgotten)
    return s._replace(
        x=x,
        safe=s.x,
        outer=choose(escape, x, choose(restart, s.x, s.outer)),
        multipliers=multipliers,
        penalty=penalty,
        radius=xp.where(phase == Phase.NEWTON, s.radius, trial.radius),
        goal=xp.where(escape | turned, FIRST_GOAL, decision.goal),
        phase=phase,
        anchor=choose(newton, Anchor(s.x, decision.multipliers, seen.total), s.anchor),
        inner=xp.where(restart, 0, s.inner + 1),
        stuck=no(trial.lowered) & no(newton),
        curved=trial.curved & no(newton) & trial.lowered,
        violation=xp.where(decision.ended, xp.minimum(s.violation, decision.far), s.violation),
        stalls=xp.where(turned, 0, decision.stalls),
        restorations=s.restorations + decision.hopeless,
        escapes=s.escapes + escape,
        retreats=xp.zeros_like(s.retreats),
        settled=xp.where(escape, 0, s.settled),
        finishing=xp.asarray(False),
        stationary=stationary,
        method=trial.method,
    )
