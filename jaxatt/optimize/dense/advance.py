"""Last part of an iteration: end, or move to the next point."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense.decide import Decision
from jaxatt.optimize.dense.look import Look
from jaxatt.optimize.dense.state import FIRST_GOAL, RUNNING, Anchor, Phase, State, choose
from jaxatt.optimize.dense.task import Task
from jaxatt.optimize.dense.trials import Trial
from jaxatt.optimize.status import Status

_SETTLED = 8
_MOST_ESCAPES = 5
_MOST_RETREATS = 60
_BOTTOMLESS = -1e14
_FAR_AWAY = 1e10


def advance(task: Task, s: State, seen: Look, decision: Decision, trial: Trial) -> State:
    """State at the start of the next iteration."""
    escape, worse = _saddle(task, s, seen, trial)
    status = _status(s, seen, decision, seen.finishing & ~escape)
    moved = _moved(s, seen, decision, trial, escape, worse)

    # By rising precedence.  A failed trial of Newton steps goes back to where it began.
    failed, runaway = decision.failed, decision.runaway
    retreats = ~seen.finite & ~seen.trying
    # Settled below tolerance: end at the best point, after a last look at its curvature.
    settles = (s.settled >= _SETTLED) & ~seen.finishing
    ends = status != RUNNING
    stays = failed | runaway | retreats | settles | ends
    retreats, settles = retreats & ~settles & ~ends, settles & ~ends
    runaway = runaway & ~(retreats | settles | ends)
    failed = failed & ~(runaway | retreats | settles | ends)
    result = choose(stays, s, moved)
    anew = failed | runaway
    x = jnp.where(failed, s.anchor.x, jnp.where(runaway, s.outer, result.x))
    x = jnp.where(retreats, 0.5 * (s.safe + s.x), x)
    multipliers = jnp.where(failed, s.anchor.multipliers, result.multipliers)
    radius = jnp.where(runaway, 1.0, jnp.where(retreats, 0.25 * s.radius, result.radius))
    phase = jnp.where(failed, Phase.DESCENT, result.phase)
    return result._replace(
        x=jnp.where(settles, s.stationary.x, x),
        safe=jnp.where(failed, s.anchor.x, result.safe),
        multipliers=jnp.where(settles, s.stationary.multipliers, multipliers),
        penalty=jnp.where(runaway, decision.penalty, result.penalty),
        radius=radius,
        phase=jnp.where(settles, Phase.NEWTON, phase),
        inner=jnp.where(anew, 0, result.inner),
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
    here = seen.here
    room = 1e-5 * jnp.maximum(1.0, jnp.abs(here.objective))
    room = room + 2.0 * task.limits.tolerance * jnp.sum(jnp.abs(here.residuals.multipliers))
    worse = s.feasible.objective < here.objective - room
    escape = seen.finishing & (trial.downhill | worse) & (s.escapes < _MOST_ESCAPES)
    return escape, worse


def _status(s: State, seen: Look, decision: Decision, converged: Array) -> Array:
    near = decision.near
    status = jnp.where(converged, Status.CONVERGED, RUNNING)
    status = jnp.where(decision.infeasible, Status.INFEASIBLE, status)
    status = jnp.where(decision.gave_up, Status.ITERATION_LIMIT, status)
    # A slope that fades far away from everything is no minimum either: -log(x).
    beyond = near & (decision.size > _FAR_AWAY)
    bottomless = seen.finite & near & ~seen.restoring & (seen.at.objective < _BOTTOMLESS)
    status = jnp.where(bottomless | (converged & beyond), Status.UNBOUNDED, status)
    return jnp.where(s.retreats >= _MOST_RETREATS, Status.NOT_FINITE, status)


def _moved(
    s: State, seen: Look, decision: Decision, trial: Trial, escape: Array, worse: Array
) -> State:
    """State after an ordinary iteration: at the best trial point, or at a step to be tried."""
    turned, newton = decision.turned, decision.newton
    restart = decision.ended | turned | decision.runaway | escape
    x = jnp.where(trial.lowered | escape, trial.x, s.x)
    multipliers = decision.merit.multipliers
    if trial.newton is not None:
        steps = newton & ~escape
        x = jnp.where(steps, trial.newton.x, x)
        multipliers = jnp.where(steps, trial.newton.multipliers, multipliers)
    # The best feasible point seen is no worse than the saddle or maximum that this one is.
    better = escape & worse
    x = jnp.where(better, s.feasible.x, x)
    penalty = jnp.where(better, jnp.maximum(10.0 * decision.penalty, 100.0), decision.penalty)
    phase = jnp.where(escape, Phase.DESCENT, decision.phase)
    forgotten = jax.tree.map(lambda leaf: jnp.where(escape, jnp.inf, leaf), s.stationary.residuals)
    return s._replace(
        x=x,
        safe=s.x,
        outer=jnp.where(escape, x, jnp.where(restart, s.x, s.outer)),
        multipliers=multipliers,
        penalty=penalty,
        radius=jnp.where(phase == Phase.NEWTON, s.radius, trial.radius),
        goal=jnp.where(escape | turned, FIRST_GOAL, decision.goal),
        phase=phase,
        anchor=choose(newton, Anchor(s.x, decision.multipliers, seen.total), s.anchor),
        inner=jnp.where(restart, 0, s.inner + 1),
        stuck=~trial.lowered & ~newton,
        curved=trial.curved & ~newton & trial.lowered,
        violation=jnp.where(decision.ended, jnp.minimum(s.violation, decision.far), s.violation),
        stalls=jnp.where(turned, 0, decision.stalls),
        restorations=s.restorations + decision.hopeless,
        escapes=s.escapes + escape,
        retreats=jnp.zeros_like(s.retreats),
        settled=jnp.where(escape, 0, s.settled),
        finishing=jnp.asarray(False),
        stationary=s.stationary._replace(residuals=forgotten),
        method=trial.method,
    )
