"""All tasks of a plan as one programme: harvests tied by tasks of prescribed attitude.

Along a prescribed attitude the momentum of the wheels obeys a linear equation, also under the
magnetorquers' law (5.14).  So a task is one stage that maps it, and asks the harvest before to end
in the task's attitude and rate by path equalities.  What is decided together is the momentum that
one harvest leaves for the next, and through it when each lets go of the sun.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import Linearisation, OptimalControlProgram
from jaxatt.problems.net_power.plan.joint.parameters import JointParameters, JointStage
from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.wheel_limits import limit_rows
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_row

_MOTOR_ROWS = 8
"""Of a wheel in an interval: both limits, whole and falling, at both ends."""


@functools.cache
def joint_programme(form: WheelsForm) -> OptimalControlProgram:
    """Programme of a plan whose harvests have this form, with a free end."""
    base = wheels_programme(form)
    k, n, size = form.stored, form.error_size, form.controls
    limited = base.inequality is not None
    wheels_limited = form.speed_limited or form.motor_limited
    first = 3 + k  # of the total momentum among the errors

    def own(stage: JointStage, p: JointParameters) -> WheelsParameters:
        return replace(
            p.wheels,
            load=stage.load,
            speed_lower=stage.speed_lower,
            speed_upper=stage.speed_upper,
            motor_limit=stage.motor_limit,
        )

    def chosen(stage: JointStage, task: Any, interval: Any) -> Any:
        return jax.tree.map(lambda a, b: jnp.where(stage.crossing > 0.0, a, b), task, interval)

    def spent(x: Array, stage: JointStage) -> tuple[Array, Array]:
        """Energy of a task, and its slope by the wheels' momentum."""
        across = stage.across
        away = at.stored(x, form) - across.around
        bent = at.product(across.bend, away)
        return across.spent + jnp.sum((across.slope + 0.5 * bent) * away), across.slope + bent

    def idle(u: Array, stage: JointStage, p: JointParameters) -> Array:
        """Price of the controls during a task, which do nothing: what keeps them determined."""
        controls, wheels = at.split(u, form), p.wheels
        effort = wheels.effort * jnp.sum(controls.scaled**2)
        used = jnp.sum(controls.powers) + jnp.sum(controls.dipoles)
        return stage.interval.paid / wheels.energy_scale * (effort + wheels.power_scale * used)

    def after(stored: Array, stage: JointStage) -> Array:
        return at.product(stage.across.mapping, stored) + stage.across.offset

    def crossed(x: Array, stage: JointStage, p: JointParameters) -> Array:
        across = stage.across
        y = after(at.stored(x, form), stage)
        parts = [across.end, y]
        if form.torqued:
            carried = at.product(p.wheels.to_rate, y) + across.rate
            parts.append(at.product(across.turned, carried))
        if form.charge:
            parts.append((x[-1] - spent(x, stage)[0] - across.drained)[None])
        return jnp.concatenate(parts)

    def moved(x: Array, u: Array, stage: JointStage, p: JointParameters) -> tuple[Array, Array]:
        interval = base.next_and_cost(x, u, stage.interval, own(stage, p))
        task = crossed(x, stage, p), spent(x, stage)[0] + idle(u, stage, p)
        found: tuple[Array, Array] = chosen(stage, task, interval)
        return found

    def wheel_margins(stored: Array, stage: JointStage, p: JointParameters) -> Array:
        """Distances of the wheels' speeds from their limits at the end of a task; what its motors
        have to give is decided by nothing."""
        speeds = at.own_speeds(after(stored, stage), at.parts(stage.across.rate), p.wheels)
        speeds_alone = replace(form, motor_limited=False)
        still = jnp.zeros(form.wheels)
        rows = limit_rows(jnp.stack([speeds, speeds]), still, own(stage, p), speeds_alone)
        return jnp.concatenate([*rows, jnp.ones(_MOTOR_ROWS * form.wheels * form.motor_limited)])

    def margins(x: Array, u: Array, stage: JointStage, p: JointParameters) -> Array:
        powers = at.split(u, form).powers
        rows = [jnp.repeat(powers, 2)]
        if form.charge:
            rows.append((x[-1] - p.wheels.floor)[None])
        if wheels_limited:
            rows.append(wheel_margins(at.stored(x, form), stage, p))
        return jnp.concatenate(rows)

    def inequality(x: Array, u: Array, stage: JointStage, p: JointParameters) -> Array:
        interval = base.inequalities(x, u, stage.interval, own(stage, p))
        return jnp.asarray(chosen(stage, margins(x, u, stage, p), interval))

    def equality(x: Array, u: Array, stage: JointStage, p: JointParameters) -> Array:
        across = stage.across
        missed = jnp.stack(at.rate(x, p.wheels, form)) - across.rate
        rows = jnp.concatenate([attitude_row(across.begin, x[:4]), RATE_SCALE * missed])
        return stage.crossing * rows

    def of_task(x: Array, u: Array, x_next: Array, stage: JointStage, p: JointParameters) -> Any:
        """Gap, dynamics, cost and margins of a task to first order."""
        across, wheels = stage.across, p.wheels
        gap = base.difference(crossed(x, stage, p), x_next)
        slope = spent(x, stage)[1]
        dynamics = jnp.zeros((n, n + size), x.dtype).at[3:first, 3:first].set(across.mapping)
        if form.torqued:
            through = at_matrix(across.turned, at_matrix(wheels.to_rate, across.mapping))
            dynamics = dynamics.at[first : first + 3, 3:first].set(through)
        if form.charge:
            dynamics = dynamics.at[n - 1, n - 1].set(1.0).at[n - 1, 3:first].set(-slope)
        by_controls = jax.grad(idle)(u, stage, p)
        cost = jnp.zeros(n + size, x.dtype).at[3:first].set(slope).at[n:].set(by_controls)
        rows = None
        if limited:
            powers = n + form.wheels + jnp.repeat(jnp.arange(form.powers), 2)
            rows = jax.nn.one_hot(powers, n + size, dtype=x.dtype)
            if form.charge:
                rows = jnp.concatenate([rows, jax.nn.one_hot(n - 1, n + size, dtype=x.dtype)[None]])
            if wheels_limited:
                by_stored = jax.jacfwd(wheel_margins)(at.stored(x, form), stage, p)
                more = jnp.zeros((len(by_stored), n + size), x.dtype).at[:, 3:first].set(by_stored)
                rows = jnp.concatenate([rows, more])
        return gap, dynamics, cost, margins(x, u, stage, p) if limited else None, rows

    def linearisation(
        x: Array, u: Array, x_next: Array, stage: JointStage, p: JointParameters
    ) -> Linearisation:
        assert base.linearisation is not None
        interval = base.linearisation(x, u, x_next, stage.interval, own(stage, p))
        task = of_task(x, u, x_next, stage, p)
        gap, dynamics, cost, path, path_slope = chosen(
            stage, task, (*interval[:3], interval.path, interval.path_slope)
        )
        return Linearisation(gap, dynamics, cost, interval.kept, path, path_slope)

    def lagrangian_hessian(
        x: Array,
        u: Array,
        x_next: Array,
        stage: JointStage,
        p: JointParameters,
        costate: Array,
        kept: Any,
    ) -> Array:
        assert base.lagrangian_hessian is not None
        interval = base.lagrangian_hessian(
            x, u, x_next, stage.interval, own(stage, p), costate, kept
        )
        weight = 1.0 - costate[n - 1] if form.charge else jnp.ones(())
        pulled = 2.0 * stage.interval.paid * p.wheels.effort / p.wheels.energy_scale
        effort = jnp.zeros(n + size, x.dtype).at[n : n + form.wheels].set(pulled)
        task = jnp.diag(effort).at[3:first, 3:first].add(weight * stage.across.bend)
        return jnp.asarray(chosen(stage, task, interval))

    def path_hessian(
        x: Array, u: Array, stage: JointStage, p: JointParameters, dual: Array, kept: Any
    ) -> Array:
        assert base.path_hessian is not None
        interval = base.path_hessian(x, u, stage.interval, own(stage, p), dual, kept)
        return (1.0 - stage.crossing) * interval

    return replace(
        base,
        start=lambda p: p.wheels.start,
        stages=lambda p: p.stages,
        dynamics=lambda x, u, stage, p: moved(x, u, stage, p)[0],
        cost=lambda x, u, stage, p, smoothing: moved(x, u, stage, p)[1],
        moved=moved,
        terminal_cost=None
        if base.terminal_cost is None
        else lambda x, p: base.final_cost(x, p.wheels),
        inequality=inequality if limited else None,
        equality=equality,
        final_inequality=None
        if base.final_inequality is None
        else lambda x, p: base.final_inequalities(x, p.wheels),
        limits=lambda stage, p: base.control_limits(stage.interval, p.wheels),
        linearisation=linearisation,
        lagrangian_hessian=lagrangian_hessian,
        path_hessian=path_hessian if limited else None,
    )


def at_matrix(a: Array, b: Array) -> Array:
    """Product of two small matrices, without a matrix product for every stage."""
    return sum(
        (a[:, i, None] * b[None, i] for i in range(1, a.shape[1])), a[:, 0, None] * b[None, 0]
    )
