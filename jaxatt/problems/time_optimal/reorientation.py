"""Programme of a reorientation in free time: time plus weighted squared torque.

    minimise  sum of h_k (1 + rho |u_k|^2)   over torques u_k and the final time

Problem II of Sensors and Materials 32 (5), 2020, 1671 ff., eqs. (22) to (26), with the sum in (22)
over all intervals; rho = 0 is the minimum-time problem.  The logarithm of the mean interval is a
state that nothing changes and whose first value is decided with the torques (time dilation), so
that no length is ever negative and the stages stay tied to their neighbours only.

A state holds the attitude, omega_ib (3) [rad/s], where thrusters or wheels that turn at the start
ask for it the total momentum (3) in body axes over the unit of inertia [rad/s], where wheel speeds
are limited, or their bias is asked for, the impulse of every control [s], and the logarithm of the
mean interval.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import mrp
from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.problems.pointing.cones import pointing_margins
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_rows, rolled_rate
from jaxatt.problems.time_optimal.derivatives import IntervalDerivatives, torques
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.simulation.free_body import BodyForm, derivative, step
from jaxatt.spacecraft.wheel_motor import motor_margins


@dataclass(frozen=True)
class ReorientationForm:
    """Static choices, which are compiled in: the body's form, and which limits there are.

    motor_limited : whether the torque of a wheel's motor depends on its speed.
    biased : whether a bias of the wheels is asked for at the end.
    """

    body: BodyForm
    shortest_limited: bool = False
    longest_limited: bool = False
    speed_limited: bool = False
    motor_limited: bool = False
    biased: bool = False
    cones: int = 0
    rate_limited: bool = False

    @property
    def carries_impulses(self) -> bool:
        """Whether wheel speeds matter, so that the impulse of every control is a state."""
        return self.speed_limited or self.motor_limited or self.biased


@functools.cache
def reorientation(form: ReorientationForm, size: int) -> OptimalControlProgram:
    """Programme with `size` controls an interval, of `ReorientationParameters`."""
    body = form.body
    quaternion = body.attitude == "quaternion"
    carried, turn = body.size, body.attitude_size
    impulses = size if form.carries_impulses else 0
    closed = IntervalDerivatives(body, impulses, size)
    limited = form.cones or form.rate_limited or form.speed_limited or form.motor_limited
    time_limited = form.shortest_limited or form.longest_limited

    def start(p: ReorientationParameters) -> Array:
        return jnp.concatenate([p.start, jnp.zeros(impulses, p.start.dtype), jnp.log(p.step)[None]])

    def dynamics(x: Array, u: Array, share: Array, p: ReorientationParameters) -> Array:
        h = share * jnp.exp(x[-1])
        end = step(tuple(x[i] for i in range(carried)), torques(p, u), h, p.body, body)
        return jnp.concatenate([jnp.stack(end), x[carried:-1] + h * u[:impulses], x[-1:]])

    def cost(
        x: Array, u: Array, share: Array, p: ReorientationParameters, smoothing: Array
    ) -> Array:
        squared = jnp.sum((p.scale * u) ** 2)
        return share * jnp.exp(x[-1]) * (1.0 + p.effort_weight * squared)

    def wheel_speeds(x: Array, p: ReorientationParameters) -> Array:
        spun = jnp.sum(p.to_wheels * x[carried:-1][None], axis=1) / p.wheel_inertia
        turned = jnp.sum(
            p.wheel_axes * (x[turn : turn + 3] - p.start[turn : turn + 3])[:, None], axis=0
        )
        return p.wheel_speed + spun - turned

    def final_rows(x: Array, p: ReorientationParameters) -> Array:
        q, reference = x[:turn], p.reference
        if not quaternion:
            q, reference = mrp.to_quaternion(q), mrp.to_quaternion(reference)
        if quaternion or p.held.shape[0] == 2:
            missing = attitude_rows(reference, q, p.held)
        else:
            missing = 4.0 * (x[:3] - p.reference)
        wanted = rolled_rate(reference, p.reference_rate, q, p.held)
        rows = [missing, RATE_SCALE * (x[turn : turn + 3] - wanted)]
        if form.biased:
            off = p.wheel_inertia * (wheel_speeds(x, p) - p.wheel_bias)
            rows.append(RATE_SCALE * jnp.sum(p.null_momenta * off[None], axis=1))
        return jnp.concatenate(rows)

    def inequality(x: Array, u: Array, share: Array, p: ReorientationParameters) -> Array:
        rows = []
        if form.cones or form.rate_limited:
            q = x[:4] if quaternion else mrp.to_quaternion(x[:3])
            rows.append(pointing_margins(q, x[turn : turn + 3], p.directions, p.limits))
        if not form.speed_limited and not form.motor_limited:
            return jnp.concatenate(rows)
        speeds = wheel_speeds(x, p)
        if form.speed_limited:
            rows += [
                jnp.sign(p.speed_upper) - speeds / jnp.abs(p.speed_upper),
                speeds / jnp.abs(p.speed_lower) - jnp.sign(p.speed_lower),
            ]
        if form.motor_limited:
            taken = jnp.sum(p.to_wheels * u[None], axis=1)
            rates = derivative(tuple(x[i] for i in range(carried)), torques(p, u), p.body, body)
            turning = jnp.stack(rates[turn : turn + 3])
            spinning = taken / p.wheel_inertia - jnp.sum(p.wheel_axes * turning[:, None], axis=0)
            for at in (speeds, speeds + share * jnp.exp(x[-1]) * spinning):
                rows += motor_margins(p.motors, taken / p.wheel_limit, at, p.motor_limit)
        return jnp.concatenate(rows)

    def final_inequality(x: Array, p: ReorientationParameters) -> Array:
        # Of the logarithm, which is a state: linear, however far a limit is from the answer.
        time = jnp.log(jnp.sum(p.share)) + x[-1]
        rows = [time - jnp.log(p.shortest)] if form.shortest_limited else []
        rows += [jnp.log(p.longest) - time] if form.longest_limited else []
        return jnp.stack(rows)

    program = OptimalControlProgram(
        start=start,
        stages=lambda p: p.share,
        dynamics=dynamics,
        cost=cost,
        error_size=carried - turn + 3 + impulses + 1,
        inequality=inequality if limited else None,
        final_rows=final_rows,
        final_inequality=final_inequality if time_limited else None,
        limits=lambda share, p: (p.lower, p.upper),
        free_start=1,
    )
    if not quaternion:
        return program
    return replace(
        program,
        retract=retract,
        difference=difference,
        linearisation=closed.linearisation,
        lagrangian_hessian=closed.lagrangian_hessian,
    )
