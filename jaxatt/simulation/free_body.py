"""Dynamics of a rigid body with wheels and thrusters in the inertial frame, one interval at a time.

Attitude as a unit quaternion or as modified Rodrigues parameters (MRP), integrated by Runge-Kutta
or, as some papers print it, by forward Euler.  Components stand alone for the reasons given in
`momentum_model`.

Sources: Sensors and Materials 32 (5), 2020, 1671 ff., eqs. (1) to (5), (15) and (18), where the
total momentum starts from rest at zero; Kristiansen and Gravdahl (2023), eqs. (8b) and (8c).
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.simulation.momentum_model import Components, cross, matvec, turning_rate

_NEXT_POINT = (0.5, 0.5, 1.0, 0.0)
_WEIGHT = (1 / 6, 1 / 3, 1 / 3, 1 / 6)


@dataclass(frozen=True)
class BodyForm:
    """Static choices of the model, which are compiled in.

    attitude : "quaternion" or "mrp".  integration : "rk4" or "euler".
    momentum : "zero", where it is zero and stays so; "own", J omega, without wheels; "carried",
        three states more.
    substeps : steps of the integration an interval.
    largest_mrp : norm of MRP beyond which they are switched to the other set: 1 for the shorter
        turn; an optimisation switches later, so that a path up to 1.6 pi long is one smooth motion.
    """

    attitude: str = "quaternion"
    integration: str = "rk4"
    momentum: str = "zero"
    substeps: int = 1
    largest_mrp: float = 1.0

    @property
    def attitude_size(self) -> int:
        """Number of attitude coordinates."""
        return 4 if self.attitude == "quaternion" else 3

    @property
    def size(self) -> int:
        """Number of states."""
        return self.attitude_size + (6 if self.momentum == "carried" else 3)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class FreeBody:
    """Inertia of the body.

    inertia : (3, 3) [kg m^2], total, wheels included.  inverse : (3, 3), of J_s.
    """

    inertia: Array
    inverse: Array


def mrp_rate(sigma: Components, w: Components) -> Components:
    """Derivative of MRP at a body rate w [rad/s]; the source's eqs. (4) and (5)."""
    squared = sum(s * s for s in sigma)
    along = sum(s * x for s, x in zip(sigma, w, strict=True))
    turned = cross(sigma, w)
    return tuple(
        0.25 * ((1.0 - squared) * w[i] + 2.0 * turned[i] + 2.0 * along * sigma[i]) for i in range(3)
    )


def switched(sigma: Components, largest: float = 1.0) -> Components:
    """MRP, switched to the shadow set where their norm exceeds `largest`."""
    squared = sum(s * s for s in sigma)
    outside = squared > largest**2
    scale = jnp.where(outside, -1.0 / jnp.where(outside, squared, 1.0), 1.0)
    return tuple(scale * s for s in sigma)


def derivative(state: Components, torque: Components, body: FreeBody, form: BodyForm) -> Components:
    """Time derivative of the state.

    state : attitude, omega_ib (3) [rad/s] and, where it is carried, the total momentum (3)
        [N m s], the last two in body axes.
    torque : six scalars [N m] in body axes, torque on the wheels, of which the body receives the
        negative, then torque of the thrusters.
    """
    size = form.attitude_size
    attitude, w, wheel, thrust = state[:size], state[size : size + 3], torque[:3], torque[3:]
    kinematics = turning_rate if form.attitude == "quaternion" else mrp_rate
    turning = kinematics(attitude, w)
    if form.momentum == "zero":
        return turning + matvec(body.inverse, tuple(-t for t in wheel))
    h = matvec(body.inertia, w) if form.momentum == "own" else state[size + 3 :]
    change = tuple(c + t for c, t in zip(cross(h, w), thrust, strict=True))
    rate = matvec(body.inverse, tuple(c - t for c, t in zip(change, wheel, strict=True)))
    return turning + rate + (change if form.momentum == "carried" else ())


def _tidied(state: Components, form: BodyForm) -> Components:
    size = form.attitude_size
    if form.attitude == "mrp":
        return switched(state[:size], form.largest_mrp) + state[size:]
    scale = lax.rsqrt(sum(x * x for x in state[:4]))
    return tuple(x * scale for x in state[:4]) + state[4:]


def step(
    state: Components, torque: Components, h: Array, body: FreeBody, form: BodyForm
) -> Components:
    """State after one interval of h [s] with constant torques; see `derivative`.

    A quaternion is normalised and MRP are switched where they are too large, after every step of
    the integration.
    """
    part = h / form.substeps

    def euler(base: Components) -> Components:
        slope = derivative(base, torque, body, form)
        return tuple(x + part * dx for x, dx in zip(base, slope, strict=True))

    def runge_kutta(base: Components) -> Components:
        def stage(
            carry: tuple[Components, Components], inputs: tuple[Array, Array]
        ) -> tuple[tuple[Components, Components], None]:
            point, total = carry
            ahead, weight = inputs
            slope = derivative(point, torque, body, form)
            point = tuple(x + ahead * part * dx for x, dx in zip(base, slope, strict=True))
            total = tuple(x + weight * part * dx for x, dx in zip(total, slope, strict=True))
            return (point, total), None

        coefficients = (jnp.asarray(_NEXT_POINT), jnp.asarray(_WEIGHT))
        (_, end), _ = lax.scan(stage, (base, base), coefficients)
        return end

    advance = euler if form.integration == "euler" else runge_kutta

    def substep(base: Components, _: None) -> tuple[Components, None]:
        return _tidied(advance(base), form), None

    if form.substeps == 1:
        return substep(state, None)[0]
    return lax.scan(substep, state, None, length=form.substeps)[0]
