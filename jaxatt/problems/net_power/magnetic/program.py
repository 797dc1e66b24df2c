"""Programme of a manoeuvre by magnetorquers alone in free time, eq. (6.2).

    minimise  J_F - (1/T) integral of P dt + k3 T   over dipoles m_k and the final time T

or, by energy, J_F - integral of P dt + k3 T.  The logarithm of the final time is a state that
nothing changes and whose first value is decided with the dipoles (time dilation); the nodes move
with it, and with them field, sun and eclipse.  A state holds q_ib, omega_ib in radians per unit of
time (`MagneticParameters.unit`), and that logarithm; a control is a dipole in units of its limit.

Source: Kristiansen (2023), chapter 6.
"""

from __future__ import annotations

import functools

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Quaternion
from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.derivatives import StageDerivatives
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_row


@functools.cache
def magnetic_program(form: MagneticForm) -> OptimalControlProgram:
    """Programme of `MagneticParameters`."""
    stage = StageDerivatives(form)

    def start(p: MagneticParameters) -> Array:
        return jnp.concatenate([p.start, jnp.log(jnp.asarray(p.final_time))[None]])

    def cost(
        x: Array, u: Array, interval: Interval, p: MagneticParameters, smoothing: Array
    ) -> Array:
        return stage.moved(x, u, interval, p)[1]

    def terminal_cost(x: Array, p: MagneticParameters) -> Array:
        final = jnp.exp(x[-1])
        total = p.time_weight * final
        if not form.reach:
            target, missed = wanted(x, p, form)
            total = total + p.attitude_weight * (1.0 - jnp.sum(x[:4] * target))
            total = total + p.rate_weight * jnp.sum(missed**2)
        return p.scale * total

    def final_rows(x: Array, p: MagneticParameters) -> Array:
        target, missed = wanted(x, p, form)
        return jnp.concatenate([attitude_row(target, x[:4]), RATE_SCALE * missed])

    def final_inequality(x: Array, p: MagneticParameters) -> Array:
        final = jnp.exp(x[-1])
        return jnp.stack([1.0 - p.shortest / final, 1.0 - final / p.longest])

    return OptimalControlProgram(
        start=start,
        stages=lambda p: Interval(jnp.asarray(p.time), jnp.asarray(p.share)),
        dynamics=lambda x, u, interval, p: stage.moved(x, u, interval, p)[0],
        cost=cost,
        error_size=7,
        control_size=3,
        terminal_cost=terminal_cost,
        retract=retract,
        difference=difference,
        final_rows=final_rows if form.reach else None,
        final_inequality=final_inequality,
        limits=lambda interval, p: (-jnp.ones(3), jnp.ones(3)),
        free_start=1,
        linearisation=stage.linearisation,
        lagrangian_hessian=stage.lagrangian_hessian,
        moved=stage.moved,
        flight=lambda x, u, interval, p, finer: stage.moved(x, u, interval, p, finer)[0],
    )


def wanted(x: Array, p: MagneticParameters, form: MagneticForm) -> tuple[Array, Array]:
    """Attitude q_ib (4,) to end in, and the error (3,) [rad/s] of the rate, of a last state.

    The rate relative to the orbit frame is algebraic: omega_ib - R(q_ib)' omega_io.
    """
    if not form.orbit_frame:
        return p.reference, x[4:7] / p.unit - p.reference_rate
    # To second order in the logarithm of the time, which is all that is differentiated.  The
    # formulas are flat, and behind a barrier: the compiler writes out what stands before anew
    # wherever it is used.
    at = lax.stop_gradient(x[-1])
    later, final = x[-1] - at, jnp.exp(at)
    value, slope, bend = p.environment.moving.to_second_order(p.begin + final)
    orders = value, final * slope, final * slope + final**2 * bend
    target = [Quaternion.of(o[:4]).multiply(Quaternion.of(p.reference)).array for o in orders]
    turning = [order[4:7] for order in orders]
    target, turning = lax.optimization_barrier((target, turning))  # type: ignore[no-untyped-call]

    def now(orders: list[Array]) -> Array:
        return orders[0] + later * (orders[1] + 0.5 * later * orders[2])

    carried = jnp.sum(_to_body(x) * now(turning)[None, :], axis=1)
    return now(target), x[4:7] / p.unit - carried - p.reference_rate


def _to_body(x: Array) -> Array:
    """Rotation matrix (3, 3) from inertial to body axes, of a state with a unit quaternion."""
    w, i, j, k = (x[n] for n in range(4))
    rows = [
        [1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j + w * k), 2.0 * (i * k - w * j)],
        [2.0 * (i * j - w * k), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k + w * i)],
        [2.0 * (i * k + w * j), 2.0 * (j * k - w * i), 1.0 - 2.0 * (i * i + j * j)],
    ]
    return jnp.stack([jnp.stack(row) for row in rows])
