"""One Runge-Kutta step of a body with wheels, with the motion between its ends.

As `rigid_step`, where the dipole of the magnetorquers may follow the motion within the step, and
with the continuous extension of the classical method: third-order polynomials in the share of the
step that has passed, which need no further evaluation of the dynamics.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Vector
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.simulation.rigid_step import Body, Motion

Dipole = Callable[[Motion, Vector, Along], Vector | None]
"""(motion, A h, environment) -> dipole [A m^2]; h : the wheels' axial momenta, inertial [N m s]."""

_AHEAD = (0.0, 0.5, 0.5, 1.0)


class Stages(NamedTuple):
    """What a step started from, and its slopes at the four stages (leading axis 4)."""

    start: Motion
    slopes: Motion


def stages(
    start: Motion,
    wheel_momentum: Vector,
    torque: Vector,
    dipole: Dipole,
    along: Along,
    step: Array,
    body: Body,
    torques: ExternalTorques,
) -> Stages:
    """Evaluate the four stages of a step.

    wheel_momentum : A h at the start [N m s].  torque : A tau_w [N m], on the wheels; the body
    receives its negative.  along : (4, lanes), at the four stages.  step : (lanes,) or (1,) [s].
    Source: Kristiansen (2023), eqs. (5.11b) and (5.11c), with J omega + A Jw omega_RW written as
    J_s omega + A h.
    """

    def stage(before: Motion, inputs: tuple[Array, Along]) -> tuple[Motion, Motion]:
        ahead, environment = inputs
        at = jax.tree.map(lambda x, dx: x + (ahead * step) * dx, start, before)
        spun = wheel_momentum + (ahead * step) * torque
        momentum = body.without_spin @ at.omega + spun
        external = torques.total(
            at.q_ib, at.omega, environment, body.inertia, dipole(at, spun, environment)
        )
        turning = momentum.cross(at.omega) + external - torque
        slope = Motion(at.q_ib.derivative(at.omega), body.inverse @ turning)
        return slope, slope

    nothing = jax.tree.map(jnp.zeros_like, start)
    _, slopes = lax.scan(stage, nothing, (jnp.asarray(_AHEAD), along))
    return Stages(start, slopes)


def between(begun: Stages, step: Array, share: Array) -> Motion:
    """Motion at the shares (k,) of the step, leading axis k, its quaternion normalised.

    Source: Hairer, Norsett and Wanner (1993), *Solving Ordinary Differential Equations I*, section
    II.6: weights s - 3 s^2 / 2 + 2 s^3 / 3, twice s^2 - 2 s^3 / 3, and -s^2 / 2 + 2 s^3 / 3.
    """
    share = share[:, None]
    square, cube = share**2, 2.0 / 3.0 * share**3
    first = share - 1.5 * square + cube
    middle = square - cube
    last = cube - 0.5 * square

    def at(x: Array, slope: Array) -> Array:
        k1, k23, k4 = slope[0], slope[1] + slope[2], slope[3]
        rise = first * k1[None] + middle * k23[None] + last * k4[None]
        return x[None] + step[None] * rise

    motion = jax.tree.map(at, begun.start, begun.slopes)
    return Motion(motion.q_ib.normalized(), motion.omega)


def end(begun: Stages, step: Array) -> Motion:
    """Motion at the end of the step."""

    def at(x: Array, k: Array) -> Array:
        return x + step / 6.0 * (k[0] + 2.0 * (k[1] + k[2]) + k[3])

    motion = jax.tree.map(at, begun.start, begun.slopes)
    return Motion(motion.q_ib.normalized(), motion.omega)
