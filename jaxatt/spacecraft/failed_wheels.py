"""Wheels that have failed: they stand still in the body, and the others do their work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jaxatt.spacecraft.checks import FieldError, Float64, brief
from jaxatt.spacecraft.parts.wheels import ReactionWheels
from jaxatt.spacecraft.wheel_envelope import largest_about_axes, spanned_directions


def without(wheels: ReactionWheels, failed: Sequence[str]) -> ReactionWheels:
    """Return the wheels that are left where those of some names have failed.

    A failed wheel turns with the body: the total inertia has it still, the arrays of the wheels do
    not.  Raises `FieldError` for a name that no wheel has, or where the others cannot turn the body
    about every axis.
    """
    known = wheels.mounted_names
    for name in failed:
        if name not in known:
            raise FieldError(
                "failed", f"no wheel is called {brief(name)}; the wheels are {', '.join(known)}"
            )
    lost = tuple(name for name in known if name in failed or name in wheels.failed)
    left = [place for place, name in enumerate(wheels.names) if name not in lost]
    axes = np.asarray(wheels.axes)[:, left]
    spanned, blind = spanned_directions(axes)
    if spanned < 3:
        raise FieldError(
            "failed",
            f"the {len(left)} wheels left span {spanned} of the three directions: no torque is "
            f"left about ({blind}) in body axes; keep a wheel that turns the body about it",
        )
    each = (wheels.inertia, wheels.torque_limit, wheels.speed_limit)
    inertia, torque_limit, speed_limit = (np.asarray(values)[left] for values in each)
    return replace(
        wheels,
        axes=axes,
        inertia=inertia,
        torque_limit=torque_limit,
        speed_limit=speed_limit,
        avoid=wheels.avoid.of_wheels(left),
        motors=wheels.motors.of_wheels(left),
        mounted=known,
        failed=lost,
    )


def loss_sentence(whole: ReactionWheels, left: ReactionWheels) -> str:
    """Return by how much torque and stored momentum about each body axis alone fall."""
    words = "has" if len(left.failed) == 1 else "have"
    torque = _fall(1e3 * _torque(whole), 1e3 * _torque(left), "mN m")
    sentence = (
        f"{' and '.join(left.failed)} {words} failed: the largest torque about x, y, z alone "
        f"falls from {torque}"
    )
    before, after = _stored(whole), _stored(left)
    if not np.isfinite(before).any():
        return sentence
    return f"{sentence}, the momentum stored from {_fall(before, after, 'N m s')}"


def _torque(wheels: ReactionWheels) -> Float64:
    return largest_about_axes(np.asarray(wheels.axes), np.asarray(wheels.torque_limit))


def _stored(wheels: ReactionWheels) -> Float64:
    most = np.asarray(wheels.inertia) * np.asarray(wheels.speed_limit)
    return largest_about_axes(np.asarray(wheels.axes), most)


def _fall(before: Float64, after: Float64, unit: str) -> str:
    first, second = (", ".join(f"{value:.4g}" for value in v) for v in (before, after))
    return f"({first}) to ({second}) {unit}"
