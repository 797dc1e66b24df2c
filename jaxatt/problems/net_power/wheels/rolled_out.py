"""Starts of a manoeuvre from torques, along the states that the programme's dynamics lead to."""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.optimize.optimal_control import fly
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.from_flight import INSIDE, dipoles_of
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.starts import Starts, filled, towards, with_powers
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import QUICK_TO_COMPILE


def rolled_out(task: WheelsTask, torque: Floats, dipole: Floats | None = None) -> Starts:
    """Starts with torques (S, N, n) [N m], and dipoles (S, N, 3) [A m^2] where they are decided."""
    p, form = task.parameters, task.form
    count, intervals = torque.shape[:2]
    more = len(np.asarray(p.stages.step)) - intervals
    scaled = np.clip(torque / np.asarray(p.torque_limit), -INSIDE, INSIDE)
    scaled = filled(scaled, more)
    dipoles = None if dipole is None else filled(dipoles_of(p, dipole), more)
    total = np.broadcast_to(np.asarray(p.total), (count, 3))
    scale = np.full(count, float(p.power_scale))
    still = np.zeros((*scaled.shape[:2], form.powers + form.dipoles))
    if dipoles is not None:
        still[..., form.powers :] = dipoles
    x = np.asarray(_states(form, p, np.concatenate([scaled, still], axis=-1)))
    u = with_powers(task, total, scale, x, scaled, dipoles)
    if form.charge:
        x = np.asarray(_states(form, p, u))  # What the wheels take empties the battery.
    reference = np.broadcast_to(np.asarray(p.reference), (count, 4))
    return Starts(u, x, towards(reference, x[:, -1, :4]), np.zeros(count, int))


@functools.partial(jax.jit, static_argnames="form", compiler_options=QUICK_TO_COMPILE)
def _states(form: WheelsForm, p: WheelsParameters, controls: Any) -> Any:
    """States (S, N + 1, s) under controls (S, N, b) of the programme."""

    def one(u: Any) -> Any:
        x, end = fly(wheels_programme(form), u, p)
        return jnp.concatenate([x, end[None]])

    return jax.vmap(one)(controls)
