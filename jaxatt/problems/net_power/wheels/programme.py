"""Programme of a manoeuvre with wheels in fixed time: as much net energy as can be had.

    minimise  - sum of shone_k area(q_k)  + sum of h (m_k + n_k) / 2

over scaled wheel torques and, where power is a magnitude, over magnitudes of it at the beginning
and at the end of every interval, m_k >= taken p and m_k >= - returned p, rather than a rounded
corner.  Power at two instants it is because its mean over an interval can vanish while the wheels
work.  The sun is weighed at the nodes by the trapezoidal rule, whose error for manoeuvres from rest
to rest is of fourth order.  "signed" power (4.6) is an exact difference of energy, paid at the end.

Source: Kristiansen (2023), eqs. (4.9), (5.11), with the readings of its chapters 4 and 5.
"""

from __future__ import annotations

import functools

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.friction_loss import friction_loss
from jaxatt.problems.net_power.wheels.hessian import lagrangian_hessian
from jaxatt.problems.net_power.wheels.interval import Motion, motion
from jaxatt.problems.net_power.wheels.linearisation import linearisation
from jaxatt.problems.net_power.wheels.margins import path_hessian
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.sunlight import collected
from jaxatt.problems.net_power.wheels.turn import multiplied
from jaxatt.problems.net_power.wheels.wheel_limits import limit_rows
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_rows, rolled_rate
from jaxatt.simulation.momentum_model import to_body


@functools.cache
def wheels_programme(form: WheelsForm) -> OptimalControlProgram:
    """Programme of a form, of `WheelsParameters`."""
    of_z = Rows(form)

    def moved(x: Array, u: Array, stage: WheelStage, p: WheelsParameters) -> tuple[Array, Array]:
        found = motion(at.course(x, u, p, form), stage.step, stage.along, p, form)
        cost = spent(x, u, stage, p, found)
        controls = at.split(u, form)
        y = at.stored(x, form) + stage.step * at.product(p.to_stored, controls.scaled)
        parts = [jnp.stack(multiplied(at.quaternion(x), found.turn)), y]
        if form.torqued:
            first = 4 + form.stored
            parts.append(x[first : first + 3] + jnp.stack(found.push) / p.momentum_scale)
        if form.charge:
            parts.append((x[-1] - cost - stage.step * p.load / p.energy_scale)[None])
        effort = stage.paid * p.effort / p.energy_scale * jnp.sum(controls.scaled**2)
        return jnp.concatenate(parts), cost + effort

    def spent(x: Array, u: Array, stage: WheelStage, p: WheelsParameters, found: Motion) -> Array:
        controls = at.split(u, form)
        sun = to_body(at.quaternion(x), at.parts(stage.sun))
        total = -stage.shone * collected(p.panels, sun, p.smoothing).area
        total = total + 0.5 * stage.paid * p.power_scale * jnp.sum(controls.powers)
        if form.pays_friction:
            speeds = end_speeds(x, controls, stage, p, found)
            total = total + p.energy_scale * friction_loss(speeds, stage, p)
        if form.magnetorquers == "managing":
            dipole = jnp.stack(found.dipole)
            sizes = jnp.sqrt(dipole * dipole + p.rounding * p.rounding) - p.rounding
            total = total + stage.step * jnp.sum(p.dipole_price * sizes + p.dipole_loss * dipole**2)
        if form.dipoles:
            price = p.dipole_price * p.dipole_limit
            both = jnp.concatenate([price, price])
            decided = jnp.stack(at.dipole(controls, p, form))
            total = total + stage.paid * jnp.sum(both * controls.dipoles)
            total = total + stage.paid * jnp.sum(p.dipole_loss * decided**2)
        return total / p.energy_scale

    def end_speeds(
        x: Array, controls: at.Controls, stage: WheelStage, p: WheelsParameters, found: Motion
    ) -> Array:
        y = at.stored(x, form)
        y_end = y + stage.step * at.product(p.to_stored, controls.scaled)
        return jnp.stack([at.own_speeds(y, found.rate, p), at.own_speeds(y_end, found.end_rate, p)])

    def inequality(x: Array, u: Array, stage: WheelStage, p: WheelsParameters) -> Array:
        rows = []
        controls = at.split(u, form)
        found = motion(at.course(x, u, p, form), stage.step, stage.along, p, form)
        if form.powers:
            y = at.stored(x, form)
            y_end = y + stage.step * at.product(p.to_stored, controls.scaled)
            first = at.wheel_power(y, found.rate, controls.scaled, p, form)
            last = at.wheel_power(y_end, found.end_rate, controls.scaled, p, form)
            power = jnp.concatenate([first, last])
            for i in range(form.powers):
                rows += [
                    controls.powers[i] - p.taken * power[i],
                    controls.powers[i] + p.returned * power[i],
                ]
        if form.charge:
            rows.append(x[-1] - p.floor)
        limits: list[Array] = []
        if form.speed_limited or form.motor_limited:
            speeds = end_speeds(x, controls, stage, p, found)
            limits = limit_rows(speeds, controls.scaled, p, form)
        return jnp.concatenate([*([jnp.stack(rows)] if rows else []), *limits])

    def final_rows(x: Array, p: WheelsParameters) -> Array:
        omega = jnp.stack(at.rate(x, p, form))
        wanted = rolled_rate(p.reference, p.reference_rate, x[:4], p.held)
        rows = [RATE_SCALE * (omega - wanted)]
        if form.end in ("reach", "point"):
            rows.append(attitude_rows(p.reference, x[:4], p.held))
        if form.speeds:
            # Momenta of the wheels are about their axes in space, so they count how the body turns.
            carried = p.wheel_inertia * at.product(p.axes.T, wanted - p.reference_rate)
            missed = at.stored(x, form) - p.reference_stored - carried / p.momentum_scale
            rows.append(RATE_SCALE * at.product(p.end_rows, missed))
        return jnp.concatenate(rows)

    def limits(stage: WheelStage, p: WheelsParameters) -> tuple[Array, Array]:
        open_ended = jnp.full(form.powers, jnp.inf)
        one = jnp.ones(form.wheels)
        dipoles = jnp.ones(form.dipoles)
        lower = jnp.concatenate([-one, -open_ended, 0.0 * dipoles])
        return lower, jnp.concatenate([one, open_ended, dipoles])

    # From a given start to a given end without external torques, nothing is left to pay for there.
    settled = form.end == "reach" and not (
        form.power == "signed" and (form.torqued or form.wheels > 3)
    )
    limited = form.powers > 0 or form.charge or form.speed_limited or form.motor_limited
    return OptimalControlProgram(
        start=lambda p: p.start,
        stages=lambda p: p.stages,
        dynamics=lambda x, u, stage, p: moved(x, u, stage, p)[0],
        cost=lambda x, u, stage, p, smoothing: moved(x, u, stage, p)[1],
        error_size=form.error_size,
        control_size=form.controls,
        terminal_cost=None if settled else functools.partial(terminal_cost, form),
        retract=retract,
        difference=difference,
        inequality=inequality if limited else None,
        final_inequality=(lambda x, p: (x[-1] - p.floor)[None]) if form.charge else None,
        final_rows=final_rows if form.end in ("reach", "point", "rate") else None,
        limits=limits,
        linearisation=functools.partial(linearisation, of_z),
        lagrangian_hessian=functools.partial(lagrangian_hessian, of_z),
        path_hessian=functools.partial(path_hessian, of_z) if limited else None,
        moved=moved,
        integrals=int(form.charge),
    )


def terminal_cost(form: WheelsForm, x: Array, p: WheelsParameters) -> Array:
    """Cost () of the last state: its sunlight, what signed power paid, and weighted errors."""
    q = at.quaternion(x)
    omega = jnp.stack(at.rate(x, p, form))
    sun = to_body(q, at.parts(p.last_sun))
    total = -p.last_shone * collected(p.panels, sun, p.smoothing).area
    if form.power == "signed":
        total = total + p.taken * at.kinetic_energy(x, omega, p, form)
    if form.end in ("penalty", "rate"):
        inner = jnp.sum(p.reference * x[:4])
        total = total + p.attitude_weight * (1.0 - inner)
    if form.end == "penalty":
        total = total + p.rate_weight * jnp.sum((omega - p.reference_rate) ** 2)
    return total / p.energy_scale
