"""Magnetic feedback along a path of attitudes, to start the optimiser from."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import cross, dot
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.program import magnetic_program
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import QUICK_TO_COMPILE

_FREQUENCY, _DAMPING = 1.2, 0.9
"""Of the closed loop, in radians per unit of time: slow against an interval's hold."""
_MOST = 0.95
"""Share of the largest dipole that is used."""


def follow(task: MagneticTask, paths: Floats, final: Floats) -> tuple[Array, Array]:
    """Fly along paths (S, N + 2, 4) in final times (S,) [s].

    Returns controls (S, N, 3) and states (S, N + 1, 8) of the programme.
    """
    return _followed(task.form(True), task.parameters, jnp.asarray(paths), jnp.asarray(final))


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def _followed(
    form: MagneticForm, p: MagneticParameters, paths: Array, final: Array
) -> tuple[Array, Array]:
    program = magnetic_program(form)

    def one(path: Array, final: Array) -> tuple[Array, Array]:
        begin = jnp.concatenate([p.start, jnp.log(final)[None]])

        def advance(x: Array, inputs: tuple[Array, Array, Interval]) -> tuple[Array, Array]:
            now, later, interval = inputs
            u = _law(x, now, later, interval, final, p)
            return program.dynamics(x, u, interval, p), jnp.concatenate([x, u])

        end, found = lax.scan(advance, begin, (path[:-2], path[1:-1], program.stages(p)))
        return found[:, 8:], jnp.concatenate([found[:, :8], end[None]])

    return jax.vmap(one)(paths, final)


def _law(
    x: Array, now: Array, later: Array, interval: Interval, final: Array, p: MagneticParameters
) -> Array:
    """Control (3,): a proportional-derivative torque, as far as a dipole can give it.

    now, later : (4,), attitudes of the path at the beginning and the end of the interval.
    """
    length = interval.length * final
    step = length / p.unit
    ahead = _turn(now, later) / step
    wanted = _FREQUENCY**2 * _turn(x[:4], now) + 2.0 * _DAMPING * _FREQUENCY * (ahead - x[4:7])
    torque = p.inertia @ wanted / p.unit**2
    moment = p.environment.at(p.begin + interval.time * final + 0.5 * length)
    assert moment.field is not None
    field = quaternion.rotate_inverse(x[:4], moment.field.array)
    dipole = cross(field, torque) / dot(field, field) / p.dipole_unit
    return dipole / jnp.maximum(1.0, jnp.max(jnp.abs(dipole)) / _MOST)


def _turn(q: Array, r: Array) -> Array:
    """Small turn (3,) [rad] from one attitude to another, the shorter way."""
    between = quaternion.multiply(quaternion.conjugate(q), r)
    return 2.0 * between[1:] * jnp.where(between[0] < 0.0, -1.0, 1.0)
