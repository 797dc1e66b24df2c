"""Augmented Lagrangian for small dense programmes from one start; `jax.vmap` makes it many.

As for slews the loop is flat: a pass evaluates derivatives once, decides, and moves once.  Inside
the augmented Lagrangian, with its exact Hessian, is minimised over the box; whenever that has
ended, steps of stabilised SQP are tried from there and kept while the residual of the first-order
conditions falls.  Where the violation does not shrink it is minimised by itself, to tell locally
infeasible from slow.

Sources: Nocedal & Wright (2006), chapter 17; Andreani, Birgin, Martinez & Schuverdt (2007) for the
updates; Gill & Robinson (2013) for the combination with stabilised SQP; Waechter & Biegler (2006)
for scaling and residuals.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.dense import proposals
from jaxatt.optimize.dense.active_set import fit, newton_step
from jaxatt.optimize.dense.first_order import FirstOrder
from jaxatt.optimize.dense.functions import Functions, Local
from jaxatt.optimize.dense.residuals import Box, Residuals, largest, residuals, violated
from jaxatt.optimize.dense.start import Draws, begin
from jaxatt.optimize.dense.state import Anchor, Limits, Phase, Record, State, choose
from jaxatt.optimize.dense.trust_region import spectrum_of
from jaxatt.optimize.penalty import pushed
from jaxatt.optimize.status import Status

_RUNNING = -1
_TARGET = 1e-10
_NEWTON_SHRINKS = 0.9
_SETTLED = 8
_FIRST_GOAL = 1e-2
_LEAST_GOAL = 1e-11
_SHRINKS_WELL = 0.25
_GROWTH = 10.0
_LARGEST_PENALTY = 1e15
_LARGEST_MULTIPLIER = 1e10
_MOST_STALLS = 4
_MOST_RESTORATIONS = 3
_MOST_ESCAPES = 5
_MOST_RESETS = 12
_MOST_RETREATS = 60
_PROBING_PENALTY = 1e7
_BOTTOMLESS = -1e14
_FAR_AWAY = 1e10


class Ending(NamedTuple):
    """How one start ended: its best point, status () and passes ()."""

    found: Record
    status: Array
    iterations: Array


class _Merit(NamedTuple):
    """Augmented Lagrangian with weight () of the objective, multipliers (q,) and penalty ()."""

    weight: Array
    multipliers: Array
    penalty: Array
    equal: Array

    def estimate(self, rows: Array) -> Array:
        """First-order multipliers (q,); those of inequalities are not positive."""
        free = self.multipliers + self.penalty * rows
        return jnp.where(self.equal, free, -pushed(-self.multipliers, self.penalty, rows))

    def value(self, objective: Array, rows: Array) -> Array:
        """() at evaluated rows."""
        shift = jnp.sum(self.estimate(rows) ** 2 - self.multipliers**2)
        return self.weight * objective + shift / (2.0 * self.penalty)


def solve(
    functions: Functions,
    draws: Draws,
    args: Any,
    box: Box,
    limits: Limits,
    inner: str,
) -> Ending:
    """Minimise from one start.

    inner : "newton", "gauss-newton", "lbfgs" or "adam".  Nothing raises inside.
    """
    m, p = functions.counts(draws.x0, args)
    n, q = draws.x0.shape[0], m + p
    dtype = draws.x0.dtype
    equal = jnp.arange(q) < m
    first_order = FirstOrder(inner) if inner in FirstOrder.NAMES else None
    began = begin(functions, draws, args, box)
    scale = began.scale

    unit = began.unit
    box = Box(box.lower / unit, box.upper / unit)
    x_begin = began.x / unit

    def rows(x: Array) -> Array:
        return functions.rows(x * unit, args) * scale

    def body(s: State) -> State:
        x = s.x
        at_rows, derivatives = functions.derivatives(x * unit, args)
        at_rows, derivatives = at_rows * scale, derivatives * scale[:, None] * unit[None, :]
        at = Local(at_rows[0], at_rows[1:], derivatives[0], derivatives[1:])
        finite = at.finite

        # Test the first-order conditions here, and remember what is worth it.
        restoring = s.phase == Phase.RESTORATION
        trying = s.phase == Phase.NEWTON
        weight = jnp.where(restoring, 0.0, 1.0)
        merit = _Merit(weight, s.multipliers, jnp.where(restoring, 1.0, s.penalty), equal)
        estimate = merit.estimate(at.rows)
        tested = jnp.where(trying, s.multipliers, estimate)
        error = residuals(at, tested, x, box, scale, unit, equal)
        if first_order is None:
            fitted = fit(at, tested, x, box, equal)
            error_fitted = residuals(at, fitted, x, box, scale, unit, equal)
            fits = trying & (error_fitted.total < error.total)
            tested = jnp.where(fits, fitted, tested)
            error = choose(fits, error_fitted, error)
            s = s._replace(multipliers=jnp.where(fits, fitted, s.multipliers))
        total = jnp.where(finite, error.total, jnp.inf)
        here = Record(x, tested, at.objective / scale[0], error)
        met = finite & (error.violation <= limits.tolerance)
        improves = total < s.stationary.residuals.total
        nearer = finite & (error.violation < s.closest.residuals.violation)
        lower = met & (here.worth < s.feasible.worth)
        settled = jnp.where(
            s.stationary.residuals.total <= limits.tolerance,
            jnp.where(total < 0.5 * s.stationary.residuals.total, 0, s.settled + 1),
            0,
        )
        stationary = s.stationary.unless(improves, here)
        s = s._replace(
            stationary=stationary,
            feasible=s.feasible.unless(lower, here),
            closest=s.closest.unless(nearer, here),
            settled=settled,
        )
        finishing = finite & (s.finishing | (total <= jnp.minimum(limits.tolerance, _TARGET)))

        # Where the inner minimisation has ended: new multipliers, penalty and goal.
        gradient = weight * at.slope + at.jacobian.T @ estimate
        reach = largest(x - box.project(x - gradient))
        amiss = jnp.linalg.norm(violated(at.rows, equal))
        flat = (s.inner > 0) & (reach <= s.goal) & ~s.curved
        most = jnp.where(restoring, 5 * limits.max_inner, limits.max_inner)
        exhausted = s.stuck | (s.inner >= most)
        descending = s.phase == Phase.DESCENT
        ended = finite & descending & (flat | exhausted) & ~finishing
        far = largest(violated(at.rows, equal))
        well = (met & (error.product <= limits.tolerance)) | (far <= _SHRINKS_WELL * s.violation)
        safe_estimate = jnp.clip(estimate, -_LARGEST_MULTIPLIER, _LARGEST_MULTIPLIER)
        multipliers = jnp.where(ended, safe_estimate, s.multipliers)
        steeper = jnp.where(s.stalls >= _MOST_STALLS - 1, _GROWTH**2, _GROWTH)
        growth = jnp.where(ended & ~well, steeper, 1.0)
        penalty = jnp.minimum(s.penalty * growth, _LARGEST_PENALTY)
        stalls = jnp.where(ended, jnp.where(well, 0, s.stalls + 1), s.stalls)
        hopeless = ended & ~met & (stalls >= _MOST_STALLS) & (far > 0.5 * s.violation)
        goal = jnp.where(
            ended, jnp.maximum(_LEAST_GOAL, 0.1 * jnp.minimum(s.goal, 10.0 * reach)), s.goal
        )

        # Where a restoration has ended: carry on, or locally infeasible.
        spread = jnp.maximum(1.0, largest(at.jacobian))
        level = reach <= 1e-9 * amiss * spread
        restored = finite & restoring & (error.violation <= 0.1 * limits.tolerance)
        over = finite & restoring & ~restored & ((level & (s.inner > 0) & ~s.curved) | exhausted)
        infeasible = over & ~met & (reach <= 1e-5 * amiss * spread)
        last = s.restorations >= _MOST_RESTORATIONS
        gave_up = over & ~met & ~infeasible & last
        restored = restored | (over & ~infeasible & ~gave_up)
        hopeless = hopeless & (s.restorations < _MOST_RESTORATIONS)

        # Where the augmented Lagrangian, not the programme, has no minimum: more penalty.
        size = largest(x)
        near = far <= limits.tolerance * jnp.maximum(1.0, size)
        runaway = (far > 1e4 * jnp.maximum(1.0, s.violation)) | ((size > 1e12) & ~near)
        runaway = runaway & finite & descending & ~near & (s.resets < _MOST_RESETS)
        bottomless = finite & near & ~restoring & (at.objective < _BOTTOMLESS)

        # The next phase, and what it minimises.
        kept = finite & trying & (total <= _NEWTON_SHRINKS * s.anchor.total)
        failed = trying & ~kept & ~finishing
        newton_next = ((ended & ~hopeless) | kept) & ~finishing
        if first_order is not None:
            newton_next = newton_next & False
        phase = jnp.where(newton_next, Phase.NEWTON, jnp.where(restoring, s.phase, Phase.DESCENT))
        phase = jnp.where(hopeless, Phase.RESTORATION, phase)
        phase = jnp.where(restored, Phase.DESCENT, phase)
        turned = hopeless | restored
        multipliers = jnp.where(turned, 0.0, multipliers)
        penalty = jnp.where(runaway, jnp.minimum(100.0 * penalty, _LARGEST_PENALTY), penalty)
        next_weight = jnp.where(phase == Phase.RESTORATION, 0.0, 1.0)
        used = jnp.where(phase == Phase.RESTORATION, 1.0, penalty)
        used = jnp.where(finishing, jnp.maximum(used, _PROBING_PENALTY), used)
        held_multipliers = jnp.where(finishing, tested, multipliers)
        merit = _Merit(next_weight, held_multipliers, used, equal)
        estimate = merit.estimate(at.rows)
        gradient = next_weight * at.slope + at.jacobian.T @ estimate
        fixed = proposals.held(x, gradient, box)
        value = merit.value(at.objective, at.rows)

        # Trial points.
        if first_order is None:
            in_hessian = jnp.where(newton_next, multipliers, estimate)
            if inner == "gauss-newton":
                in_hessian = jnp.zeros_like(in_hessian)
            shares = jnp.concatenate([next_weight[None], in_hessian]) * scale
            hessian = functions.hessian(x * unit, args, shares)
            hessian = hessian * unit[:, None] * unit[None, :]
            hessian = jnp.nan_to_num(hessian, posinf=0.0, neginf=0.0)
            binding = jnp.where(equal | (estimate < 0), used, 0.0)
            full = hessian + at.jacobian.T @ (binding[:, None] * at.jacobian)
            spectrum = spectrum_of(full, ~fixed)
            lowest = spectrum.values[0]
            steepest = jnp.max(jnp.abs(jnp.diag(full)), initial=1.0)
            curved = lowest < -1e-9 * steepest
            shift = jnp.where(curved, -1.1 * lowest, 0.0)
            mu = jnp.where(newton_next, jnp.clip(total, 1e-10, 1.0 / used), 1.0 / used)
            newton = newton_step(
                x,
                at,
                next_weight,
                hessian + shift * jnp.eye(n, dtype=dtype),
                multipliers,
                mu,
                box,
                equal,
            )
            trials = proposals.second_order(x, gradient, spectrum, fixed, newton.x, s.radius, box)
            method = s.method
            uncertain = lowest <= 1e-7 * steepest
        else:
            fresh = ended | turned | runaway | (s.inner == 0)
            trials, method = first_order.propose(x, gradient, fixed, s.method, fresh, s.radius, box)
            curved, uncertain = jnp.asarray(False), jnp.asarray(False)
            newton = None

        trial_rows = jax.vmap(rows)(trials)
        values = jax.vmap(lambda row: merit.value(row[0], row[1:]))(trial_rows)
        values = jnp.where(jnp.isfinite(values), values, jnp.inf)
        if first_order is None:
            # Directions without a reason serve only where nothing else tells a saddle.
            reasoned = jnp.arange(values.shape[0]) < values.shape[0] - proposals.PROBES
            values = jnp.where(reasoned | finishing, values, jnp.inf)
        best = jnp.argmin(values)
        noise = 1e-15 * jnp.maximum(1.0, jnp.abs(value))
        lowered = values[best] < value - noise
        if inner == "adam":
            lowered = jnp.isfinite(values[best])
        length = jnp.linalg.norm(trials[best] - x)
        radius = jnp.where(lowered, jnp.maximum(2.0 * length, 0.1 * s.radius), 0.1 * s.radius)
        radius = jnp.clip(radius, 1e-8 * jnp.maximum(1.0, size), 1e30)

        # Done, unless this is a saddle that a trial leaves downhill.
        drop = value - values[best]
        downhill = uncertain & (drop > 1e-7 * jnp.maximum(1.0, jnp.abs(value)))
        room = 1e-5 * jnp.maximum(1.0, jnp.abs(here.objective))
        room = room + 2.0 * limits.tolerance * jnp.sum(jnp.abs(error.multipliers))
        worse = s.feasible.objective < here.objective - room
        escape = finishing & (downhill | worse) & (s.escapes < _MOST_ESCAPES)
        converged = finishing & ~escape
        status = jnp.where(converged, Status.CONVERGED, _RUNNING)
        status = jnp.where(infeasible, Status.INFEASIBLE, status)
        status = jnp.where(gave_up, Status.ITERATION_LIMIT, status)
        # A slope that fades far away from everything is no minimum either: -log(x).
        beyond = near & (size > _FAR_AWAY)
        status = jnp.where(bottomless | (converged & beyond), Status.UNBOUNDED, status)
        status = jnp.where(s.retreats >= _MOST_RETREATS, Status.NOT_FINITE, status)

        # Move.
        restart = ended | turned | runaway | escape
        moved_x = jnp.where(lowered | escape, trials[best], x)
        moved_multipliers = held_multipliers
        if newton is not None:
            moved_x = jnp.where(newton_next & ~escape, newton.x, moved_x)
            moved_multipliers = jnp.where(
                newton_next & ~escape, newton.multipliers, held_multipliers
            )
        # The best feasible point seen is no worse than the saddle or maximum that this one is.
        moved_x = jnp.where(escape & worse, s.feasible.x, moved_x)
        penalty = jnp.where(escape & worse, jnp.maximum(10.0 * penalty, 100.0), penalty)
        phase = jnp.where(escape, Phase.DESCENT, phase)
        moved = s._replace(
            x=moved_x,
            safe=x,
            outer=jnp.where(escape, moved_x, jnp.where(restart, x, s.outer)),
            multipliers=moved_multipliers,
            penalty=penalty,
            radius=jnp.where(phase == Phase.NEWTON, s.radius, radius),
            goal=jnp.where(escape | turned, _FIRST_GOAL, goal),
            phase=phase,
            anchor=choose(newton_next, Anchor(x, multipliers, total), s.anchor),
            inner=jnp.where(restart, 0, s.inner + 1),
            stuck=~lowered & ~newton_next,
            curved=curved & ~newton_next & lowered,
            violation=jnp.where(ended, jnp.minimum(s.violation, far), s.violation),
            stalls=jnp.where(turned, 0, stalls),
            restorations=s.restorations + jnp.where(hopeless, 1, 0),
            escapes=s.escapes + jnp.where(escape, 1, 0),
            retreats=jnp.asarray(0),
            settled=jnp.where(escape, 0, s.settled),
            finishing=jnp.asarray(False),
            method=method,
        )
        moved = moved._replace(
            stationary=moved.stationary._replace(
                residuals=choose(
                    escape,
                    jax.tree.map(lambda leaf: jnp.full_like(leaf, jnp.inf), error),
                    moved.stationary.residuals,
                )
            )
        )
        # A failed trial of Newton steps goes back to where it began.
        back = s._replace(
            x=s.anchor.x,
            safe=s.anchor.x,
            multipliers=s.anchor.multipliers,
            phase=jnp.asarray(int(Phase.DESCENT)),
            inner=jnp.asarray(0),
            stuck=jnp.asarray(False),
            curved=jnp.asarray(False),
        )
        reset = s._replace(
            x=s.outer,
            penalty=penalty,
            radius=jnp.ones_like(s.radius),
            inner=jnp.asarray(0),
            resets=s.resets + 1,
            stuck=jnp.asarray(False),
        )
        retreat = s._replace(x=0.5 * (s.safe + x), radius=0.25 * s.radius, retreats=s.retreats + 1)
        # Settled below tolerance: end at the best point, after a last look at its curvature.
        settle = s._replace(
            x=s.stationary.x,
            multipliers=s.stationary.multipliers,
            phase=jnp.asarray(int(Phase.NEWTON)),
            finishing=jnp.asarray(True),
        )
        result = choose(failed, back, moved)
        result = choose(runaway, reset, result)
        result = choose(~finite & ~trying, retreat, result)
        result = choose((settled >= _SETTLED) & ~finishing, settle, result)
        ended_here = status != _RUNNING
        result = choose(ended_here, s, result)
        return result._replace(status=status, iterations=s.iterations + 1)

    def running(s: State) -> Array:
        return (s.status == _RUNNING) & (s.iterations < limits.max_iterations)

    def number(value: float) -> Array:
        return jnp.asarray(value, dtype)

    def count(value: int = 0) -> Array:
        return jnp.asarray(value)

    no_rows, no_bounds = jnp.zeros((q,), dtype), jnp.zeros((n,), dtype)
    unknown = Residuals(
        number(jnp.inf), number(jnp.inf), number(jnp.inf), no_rows, no_bounds, no_bounds
    )
    blank = Record(x_begin, no_rows, number(jnp.inf), unknown)
    at_start = rows(x_begin)
    amiss = 0.5 * jnp.sum(violated(at_start[1:], equal) ** 2)
    penalty = 10.0 * jnp.maximum(1.0, jnp.abs(at_start[0])) / jnp.maximum(1.0, amiss)
    penalty = jnp.clip(jnp.where(jnp.isfinite(penalty), penalty, 1.0), 1e-2, 1e2)
    start = State(
        x=x_begin,
        safe=x_begin,
        outer=x_begin,
        multipliers=jnp.zeros((q,), dtype),
        penalty=penalty,
        radius=jnp.maximum(1.0, 0.1 * largest(x_begin)),
        goal=number(_FIRST_GOAL),
        phase=count(Phase.DESCENT),
        anchor=Anchor(x_begin, jnp.zeros((q,), dtype), number(jnp.inf)),
        inner=count(),
        stuck=jnp.asarray(False),
        curved=jnp.asarray(False),
        violation=number(jnp.inf),
        stalls=count(),
        resets=count(),
        restorations=count(),
        escapes=count(),
        retreats=count(),
        settled=count(),
        finishing=jnp.asarray(False),
        stationary=blank,
        feasible=blank,
        closest=blank,
        status=jnp.where(began.finite, _RUNNING, Status.NOT_FINITE),
        iterations=count(),
        method=first_order.init(x_begin) if first_order is not None else None,
    )
    end = lax.while_loop(running, body, start)
    return _ending(end, limits, unit)


def _ending(end: State, limits: Limits, unit: Array) -> Ending:
    """The best point that was met, and what may honestly be said of it."""
    converged = end.stationary.residuals.total <= limits.tolerance
    feasible = end.feasible.residuals.violation <= limits.tolerance
    unbounded = end.status == Status.UNBOUNDED
    converged = converged & ~unbounded
    last = Status.ITERATION_LIMIT
    status = jnp.where(end.status == _RUNNING, last, end.status)
    status = jnp.where(status == Status.CONVERGED, last, status)
    status = jnp.where(feasible & ~unbounded, Status.FEASIBLE, status)
    status = jnp.where(converged, Status.CONVERGED, status)
    found = choose(feasible, end.feasible, end.closest)
    found = choose(unbounded, end.closest, found)
    found = choose(unbounded & feasible, end.feasible, found)
    found = choose(converged, end.stationary, found)
    found = found._replace(x=found.x * unit)
    return Ending(found, status, end.iterations)
