"""Pulse widths whose flight ends where partly open thrusters would have ended."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.optimize.reweighting.bounded import bounded_step
from jaxatt.problems.hands_off.slew.model import SlewForm, SlewParameters
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.slew.thruster_response import terminal_errors, thruster_response
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.pulses import Pulses, anchors, place

_ITERATIONS = 12
_TIGHT = 1e-10
_DUAL_STEPS = 12
_HARD = 1e-13
_STIFF = 1e-2
"""Weight of a width that is all or nothing, where that of a partial one is 1: few stay partial."""


@functools.partial(jax.jit, static_argnames=("form",))
def _correction(
    u: Array, rows: Array, lower: Array, upper: Array, d: Array, p: SlewParameters, form: SlewForm
) -> Array:
    """Smallest change (N, b) of scaled controls within limits that removes rows (6,)."""
    _, jacobian = thruster_response(u, p, form)
    flat = jnp.swapaxes(jacobian, 0, 1).reshape(rows.shape[0], -1)
    weights = d.ravel()
    slack = _HARD * jnp.sum(flat**2 * weights[None], axis=-1)
    change, _ = bounded_step(
        flat,
        -rows,
        weights,
        (lower - u).ravel(),
        (upper - u).ravel(),
        slack,
        jnp.zeros(rows.shape[0], u.dtype),
        _DUAL_STEPS,
    )
    return change.reshape(u.shape)


@jax.jit
def _rows(q_ob: Array, omega_ib: Array, p: SlewParameters) -> Array:
    """Terminal errors (6,) of a flight's last state."""
    q = quaternion.multiply(p.table.nodes.orbit_attitude[-1], q_ob)
    return terminal_errors(q, omega_ib, p)


def solve_widths(
    task: SlewTask, u: Floats, sign: float, lower: Floats, upper: Floats
) -> tuple[Pulses, float]:
    """Solve for pulses near controls u (N, b) whose flight ends at the target.

    Newton's method on flights with exact switching times; derivatives are those of the mean torque.
    sign : the way round.  lower, upper : (N, b), limits; equal where nothing may change.
    Returns the pulses with the smallest largest row that was met, and that row [rad].
    """
    p = task.system.turned(task.arguments.plant, jnp.asarray(sign))
    u = np.clip(u, lower, upper)
    # Where openings belong is settled once: if it followed their widths, flights would jump.
    anchor = anchors(_duty(task, u))
    best, least = pulses_of(task, u, anchor), np.inf
    for _ in range(_ITERATIONS):
        pulses = pulses_of(task, u, anchor)
        flown, end = task.fly_pulses(pulses, coarse=True), task.intervals
        rows = _rows(flown.q_ob[0, end], flown.omega_ib[0, end], p)
        left = float(np.abs(np.nan_to_num(np.asarray(rows), nan=np.inf)).max())
        if left < least:
            best, least = pulses, left
        if left < _TIGHT or not np.isfinite(left):
            break
        partial = (u > lower + 1e-9) & (u < upper - 1e-9)
        d = np.where(partial, 1.0, _STIFF) * (upper > lower)
        u = np.clip(
            u + np.asarray(_correction(u, rows, lower, upper, d, p, task.form)), lower, upper
        )
    return best, least


def _duty(task: SlewTask, u: Floats) -> Floats:
    """Duty cycle (N, m) of each thruster at its limit."""
    return task.thrust(u * task.scale) / np.asarray(task.craft.thrusters.torque_limit)


def pulses_of(task: SlewTask, u: Floats, anchor: Floats | None = None) -> Pulses:
    """Place openings for scaled controls (N, b); see `place`."""
    duty = _duty(task, u)
    chosen = anchors(duty) if anchor is None else anchor
    return place(duty, chosen, task.wheel_torque(u * task.scale), task.step)
