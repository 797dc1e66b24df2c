"""Last part of an iteration: end, or move to the next point."""

from __future__ import annotations

from jax import Array

from jaxatt.optimize.dense.arrays import choose, namespace
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
    status = _status(s, seen, decision, seen.finishing & ~escape)
    moved = _moved(s, seen, decision, trial, escape, worse)

    # By rising precedence.  A failed trial of Newton steps goes back to where it began.
    failed, runaway = decision.failed, decision.runaway
    # Settled below tolerance: end at the best point, after a last look at its curvature.
    retreats, settles = decision.retreats, decision.settles
    ends = status != RUNNING
    stays = failed | runaway | retreats | settles | ends
    retreats, settles = retreats & ~settles & ~ends, settles & ~ends
    runaway = runaway & ~(retreats | settles | ends)
    failed = failed & ~(runaway | retreats | settles | ends)
    result = choose(stays, s, moved)
    anew = failed | runaway
    x = xp.where(failed, s.anchor.x, xp.where(runaway, s.outer, result.x))
    x = xp.where(retreats, 0.5 * (s.safe + s.x), x)
    multipliers = xp.where(failed, s.anchor.multipliers, result.multipliers)
    radius = xp.where(runaway, 1.0, xp.where(retreats, 0.25 * s.radius, result.radius))
    phase = xp.where(failed, Phase.DESCENT, result.phase)
    return result._replace(
        x=xp.where(settles, s.stationary.x, x),
        safe=xp.where(failed, s.anchor.x, result.safe),
        multipliers=xp.where(settles, s.stationary.multipliers, multipliers),
        penalty=xp.where(runaway, decision.penalty, result.penalty),
        radius=radius,
        phase=xp.where(settles, Phase.NEWTON, phase),
        inner=xp.where(anew, 0, result.inner),
        stuck=result.stuck & ~anew,
        curved=result.curved & ~failed,
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
    bottomless = seen.finite & near & ~seen.restoring & (seen.at.objective < _BOTTOMLESS)
    status = xp.where(bottomless | (converged & beyond), Status.UNBOUNDED, status)
    return xp.where(s.retreats >= _MOST_RETREATS, Status.NOT_FINITE, status)


def _moved(
    s: State, seen: Look, decision: Decision, trial: Trial, escape: Array, worse: Array
) -> State:
    """State after an ordinary iteration: at the best trial point, or at a step to be tried."""
    xp = namespace(s.x)
    turned, newton = decision.turned, decision.newton
    restart = decision.ended | turned | decision.runaway | escape
    x = xp.where(trial.lowered | escape, trial.x, s.x)
    multipliers = decision.merit.multipliers
    if trial.newton is not None:
        steps = newton & ~escape
        x = xp.where(steps, trial.newton.x, x)
        multipliers = xp.where(steps, trial.newton.multipliers, multipliers)
    # The best feasible point seen is no worse than the saddle or maximum that this one is.
    better = escape & worse
    x = xp.where(better, s.feasible.x, x)
    penalty = xp.where(better, xp.maximum(10.0 * decision.penalty, 100.0), decision.penalty)
    phase = xp.where(escape, Phase.DESCENT, decision.phase)
    known = s.stationary.residuals
    forgotten = known._replace(violation=xp.where(escape, xp.inf, known.violation))
    return s._replace(
        x=x,
        safe=s.x,
        outer=xp.where(escape, x, xp.where(restart, s.x, s.outer)),
        multipliers=multipliers,
        penalty=penalty,
        radius=xp.where(phase == Phase.NEWTON, s.radius, trial.radius),
        goal=xp.where(escape | turned, FIRST_GOAL, decision.goal),
        phase=phase,
        anchor=choose(newton, Anchor(s.x, decision.multipliers, seen.total), s.anchor),
        inner=xp.where(restart, 0, s.inner + 1),
        stuck=~trial.lowered & ~newton,
        curved=trial.curved & ~newton & trial.lowered,
        violation=xp.where(decision.ended, xp.minimum(s.violation, decision.far), s.violation),
        stalls=xp.where(turned, 0, decision.stalls),
        restorations=s.restorations + decision.hopeless,
        escapes=s.escapes + escape,
        retreats=xp.zeros_like(s.retreats),
        settled=xp.where(escape, 0, s.settled),
        finishing=xp.asarray(False),
        stationary=s.stationary._replace(residuals=forgotten),
        method=trial.method,
    )
