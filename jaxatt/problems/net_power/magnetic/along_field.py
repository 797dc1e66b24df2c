"""Whether a turn asks for a torque along the magnetic field, which magnetorquers cannot give."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.environment.in_time import EnvironmentInTime
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.problems.net_power.pose import angle_between, product
from jaxatt.runtime.arrays import Floats

NEAR = math.radians(30.0)
"""Angle between the turn's axis and the field within which half of no torque is left for it."""
_LOOKS = 65


@jax.jit
def _fields(environment: EnvironmentInTime, times: Array) -> Array:
    def at(time: Array) -> Array:
        field = environment.at(time).field
        assert field is not None
        return field.array

    return jax.vmap(at)(times)


def farthest_from_field(task: MagneticTask, final_time: float) -> float:
    """Largest angle [rad] between the axis of the turn to the target and the line of the field.

    Along the whole manoeuvre of `final_time` [s]; in inertial axes, in which the axis stands still.
    """
    m = task.manoeuvre
    begin, end = np.asarray(task.parameters.start)[:4], task.target_at(final_time).q_ib
    turn = product(end, begin * np.array([1.0, -1.0, -1.0, -1.0]))
    sine = float(np.linalg.norm(turn[1:]))
    if sine < 1e-9:
        return math.pi / 2.0
    times = m.start_time + np.linspace(0.0, final_time, _LOOKS)
    field: Floats = np.asarray(_fields(task.parameters.environment, jnp.asarray(times)))
    cosine = np.abs(field @ (turn[1:] / sine)) / np.linalg.norm(field, axis=1)
    return float(np.arccos(np.clip(cosine.min(), 0.0, 1.0)))


def field_note(task: MagneticTask, final_time: float, reached: Floats) -> str:
    """Sentence on a turn along the field; empty where it is not one.

    reached : q_ib (4,) in which the best answer ended.
    """
    away = farthest_from_field(task, final_time)
    if away > NEAR:
        return ""
    target = task.target_at(final_time).q_ib
    begin = np.asarray(task.parameters.start)[:4]
    whole, left = (math.degrees(angle_between(q, target)) for q in (begin, reached))
    return (
        f"the turn of {whole:.3g} deg asks for a torque along the magnetic field, which stays "
        f"within {math.degrees(away):.2g} deg of its axis and along which magnetorquers have none: "
        f"{left:.3g} deg were left at best; give a later longest_s, in which the field turns, or "
        "another target"
    )
