"""Flight of a body with wheels with an exact account of the energy that it gains and spends.

Powers are integrated by Gauss points within every Runge-Kutta step, at the motion in between, so
that the corners of positive parts and absolute values cost little; the light stands in the weights,
which resolve the edges of the shadow.  All lanes of a batch are scalars batched last.
"""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Vector, combination
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.dense_step import Dipole, Stages, between, end, stages
from jaxatt.simulation.light_quadrature import shares_of
from jaxatt.simulation.powers import Powers
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.wheeled_body import WheeledBody

_Tree = TypeVar("_Tree")


class Carried(NamedTuple):
    """State of a flight between two intervals.

    motion : attitude and rate.  spins : axial momentum of each wheel, inertial [N m s].
    """

    motion: Motion
    spins: tuple[Array, ...]


class Spent(NamedTuple):
    """Energies [J] of an interval, and the extremes within it.

    lowest, highest : speed of each wheel [rad/s].  strongest : largest dipole [A m^2].
    """

    solar: Array
    wheels: Array
    magnetorquers: Array
    lowest: tuple[Array, ...]
    highest: tuple[Array, ...]
    strongest: Vector


class Step(NamedTuple):
    """Surroundings of one step; trailing axis of lanes, or 1 where all share them.

    along : (4, lanes).  sun : unit vector, inertial.
    light : (points, lanes) [s], weights of the Gauss points, the sun's visible fraction in them.
    """

    along: Along
    sun: Vector
    light: Array | Floats


def fly_interval(
    body: WheeledBody,
    torques: ExternalTorques,
    powers: Powers,
    carried: Carried,
    wheel_torque: tuple[Array, ...],
    dipole: Dipole,
    steps: Step,
    step: Array,
) -> tuple[Carried, Spent]:
    """Fly one interval with held wheel torques [N m].

    steps : leading axis of the Runge-Kutta steps.  step : (lanes,) or (1,) [s], of one of them.
    """
    torque = combination(body.axes, wheel_torque, carried.motion.omega)

    def advance(at: tuple[Carried, Spent], around: Step) -> tuple[tuple[Carried, Spent], None]:
        begun, spent = at
        spun = combination(body.axes, begun.spins, begun.motion.omega)
        course = stages(begun.motion, spun, torque, dipole, around.along, step, body.body, torques)
        points = around.light.shape[0]
        within = _within(body, course, begun.spins, wheel_torque, step, points)
        middle = jax.tree.map(lambda x: x[1][None], around.along)
        moment = dipole(within.motion, _row(spun) + within.passed * _row(torque), middle)
        after = Carried(end(course, step), _spun(begun.spins, wheel_torque, step))
        return (after, _added(powers, spent, within, wheel_torque, moment, around, step)), None

    nothing = jnp.zeros_like(carried.motion.omega.x)
    none = Spent(
        nothing,
        nothing,
        nothing,
        tuple(nothing + jnp.inf for _ in wheel_torque),
        tuple(nothing - jnp.inf for _ in wheel_torque),
        Vector(nothing, nothing, nothing),
    )
    (after, spent), _ = lax.scan(advance, (carried, none), steps)
    return after, spent


class _Points(NamedTuple):
    """Time since the start of a step [s], motion and wheel speeds at its (points, lanes)."""

    passed: Array
    motion: Motion
    speeds: tuple[Array, ...]


def _within(
    body: WheeledBody,
    course: Stages,
    spins: tuple[Array, ...],
    wheel_torque: tuple[Array, ...],
    step: Array,
    points: int,
) -> _Points:
    at = jnp.asarray(shares_of(points))
    passed = at[:, None] * step[None]
    motion = between(course, step, at)
    return _Points(
        passed, motion, body.speeds(motion, _spun(_row(spins), _row(wheel_torque), passed))
    )


def _spun(
    spins: tuple[Array, ...], wheel_torque: tuple[Array, ...], passed: Array
) -> tuple[Array, ...]:
    """Axial momenta after a time; they grow linearly, exactly."""
    return tuple(s + passed * t for s, t in zip(spins, wheel_torque, strict=True))


def _added(
    powers: Powers,
    spent: Spent,
    within: _Points,
    wheel_torque: tuple[Array, ...],
    moment: Vector | None,
    around: Step,
    step: Array,
) -> Spent:
    """What was spent before a step together with what the step adds."""
    weight = step / len(within.passed)
    sun_b = within.motion.q_ib.rotate_inverse(_row(around.sun))
    spent = spent._replace(
        solar=spent.solar + jnp.sum(around.light * powers.solar(sun_b), axis=0),
        lowest=tuple(map(lower, spent.lowest, within.speeds)),
        highest=tuple(map(higher, spent.highest, within.speeds)),
    )
    if wheel_torque:
        driven = powers.wheels(_row(wheel_torque), within.speeds)
        spent = spent._replace(wheels=spent.wheels + weight * jnp.sum(driven, axis=0))
    if moment is not None:
        drawn = weight * jnp.sum(powers.magnetorquers(moment), axis=0)
        spent = spent._replace(
            magnetorquers=spent.magnetorquers + drawn,
            strongest=spent.strongest.map(_larger, moment),
        )
    return spent


def lower(least: Array, values: Array) -> Array:
    """Of a number () and several (k,), the lowest."""
    return jnp.minimum(least, jnp.min(values, axis=0))


def higher(most: Array, values: Array) -> Array:
    """Of a number () and several (k,), the highest."""
    return jnp.maximum(most, jnp.max(values, axis=0))


def _larger(most: Array, values: Array) -> Array:
    return jnp.maximum(most, jnp.max(jnp.abs(values), axis=0))


def _row(v: _Tree) -> _Tree:
    """The same with a leading axis of one, for the points within a step."""
    row: _Tree = jax.tree.map(lambda x: x[None], v)
    return row
