"""Motion over one interval of constant wheel torques, in components."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Matrix, Quaternion, Vector
from jaxatt.environment.external import Along
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.turn import added, increment, multiplied, times, turned
from jaxatt.simulation.momentum_model import Components, cross, matvec, to_body, to_inertial


class Motion(NamedTuple):
    """What an interval does; tuples of scalars.

    turn : quaternion, from the body axes of its beginning to those of its end.
    rate, end_rate : omega_ib [rad/s] in body axes, at the beginning and at the end.
    push : [N m s], impulse of the external torques in inertial axes.
    dipole : [A m^2], of managing magnetorquers, averaged.
    """

    turn: Components
    rate: Components
    end_rate: Components
    push: Components
    dipole: Components


class Course(NamedTuple):
    """A body at the beginning of an interval, and what the wheels do to it.

    attitude : q_ib; not read without external torques.  momentum : [N m s], total one in body axes.
    lost : [rad/s], rate that the wheels have taken from the body, J_s^-1 A s.  slope : [rad/s^2],
    by which they take more.  dipole : [A m^2], where it is decided.
    """

    attitude: Components
    momentum: Components
    lost: Components
    slope: Components
    dipole: Components


class _Ahead(NamedTuple):
    rate: Components
    slope: Components
    bend: Components | None
    torque: Components
    dipole: Components


def _external(
    at: Course,
    rate: Components,
    slope: Components,
    h: Array,
    along: Along,
    p: WheelsParameters,
    form: WheelsForm,
) -> tuple[Components, Components]:
    """External torque in body axes, and dipole, in the middle of an interval."""
    half = 0.5 * h
    middle = multiplied(
        at.attitude, increment(added(times(half, rate), times(0.5 * half * half, slope)))
    )
    omega = Vector(*added(rate, times(half, slope)))
    q = Quaternion(middle[0], Vector(*middle[1:]))
    dipole = Vector(*at.dipole) if form.magnetorquers == "decided" else None
    if form.magnetorquers == "managing" and p.management is not None and along.field is not None:
        lost = added(at.lost, times(half, at.slope))
        stored = Vector(*matvec(p.without_spin, lost))
        spin = Vector(*matvec(p.inertia - p.without_spin, _arrays(omega.parts)))
        excess = stored - spin - Vector.of(p.management.kept)
        field = q.rotate_inverse(along.field)
        wanted = p.management.law.dipole(excess, field)
        limit = p.management.dipole_limit
        dipole = Vector(*(jnp.clip(m, -limit[i], limit[i]) for i, m in enumerate(wanted.parts)))
    torque = p.torques.total(q, omega, along, Matrix.of(p.inertia), dipole)
    none = jnp.zeros_like(h)
    parts = (none, none, none) if dipole is None else dipole.parts
    return _arrays(torque.parts), _arrays(parts)


def _arrays(parts: Sequence[Any]) -> Components:
    return tuple(jnp.asarray(part) for part in parts)


def _ahead(
    at: Course, h: Array, along: Along | None, p: WheelsParameters, form: WheelsForm
) -> _Ahead:
    """Rate, its derivatives and the external torque at the beginning of an interval."""
    none = jnp.zeros_like(h)
    nothing = (none, none, none)
    if form.momentum == "zero":
        return _Ahead(times(-1.0, at.lost), times(-1.0, at.slope), None, nothing, nothing)
    rate = _rate(at.momentum, at.lost, p, form)
    change = cross(at.momentum, rate)
    slope = added(matvec(p.inverse, change), times(-1.0, at.slope))
    torque: Components = nothing
    dipole: Components = nothing
    if form.torqued and along is not None:
        torque, dipole = _external(at, rate, slope, h, along, p, form)
        change = added(change, torque)
        slope = added(slope, matvec(p.inverse, torque))
    bend = matvec(p.inverse, added(cross(change, rate), cross(at.momentum, slope)))
    return _Ahead(rate, slope, bend, torque, dipole)


def _rate(
    momentum: Components, lost: Components, p: WheelsParameters, form: WheelsForm
) -> Components:
    """Rate omega_ib [rad/s] in body axes."""
    if form.momentum == "zero":
        return times(-1.0, lost)
    return added(matvec(p.inverse, momentum), times(-1.0, lost))


def motion(
    start: Course, h: Array, along: Along | None, p: WheelsParameters, form: WheelsForm
) -> Motion:
    """Motion over an interval of h [s]; along : leading axis substeps."""
    part = h / form.substeps
    none = jnp.zeros_like(h)

    def step(
        carry: tuple[Course, Motion], environment: Along | None
    ) -> tuple[tuple[Course, Motion], None]:
        at, total = carry
        found = _ahead(at, part, environment, p, form)
        turn = increment(turned(found.rate, found.slope, found.bend, part))
        push, momentum = total.push, at.momentum
        if form.torqued:
            middle = added(times(0.5 * part, found.rate), times(0.125 * part * part, found.slope))
            felt = times(part, to_inertial(increment(middle), found.torque))
            push = added(push, to_inertial(at.attitude, felt))
            momentum = added(at.momentum, felt)
        momentum = to_body(turn, momentum)
        lost = added(at.lost, times(part, at.slope))
        onward = Course(
            multiplied(at.attitude, turn) if form.torqued else at.attitude,
            momentum,
            lost,
            at.slope,
            at.dipole,
        )
        so_far = Motion(
            multiplied(total.turn, turn),
            total.rate,
            _rate(momentum, lost, p, form),
            push,
            added(total.dipole, times(1.0 / form.substeps, found.dipole)),
        )
        return (onward, so_far), None

    nothing = (none, none, none)
    first_rate = _rate(start.momentum, start.lost, p, form)
    still = (none + 1.0, none, none, none)
    begun = (start, Motion(still, first_rate, first_rate, nothing, nothing))
    if form.substeps == 1:
        first = None if along is None else jax.tree.map(lambda leaf: leaf[0], along)
        return step(begun, first)[0][1]
    return lax.scan(step, begun, along, length=form.substeps)[0][1]
