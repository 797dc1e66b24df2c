"""PD law on a slew, as a baseline and as a first guess."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.control.pd import PDLaw
from jaxatt.control.schmitt import SchmittLaw
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory, fly_held_law, fly_law


def fly_pd(task: SlewTask, clipped: bool = True) -> Trajectory:
    """Fly the PD law of (5.8) on the task's slew; with thrusters, the one with Schmitt triggers."""
    reference = jnp.asarray(task.target.q_ob), jnp.asarray(task.target.omega_ob)
    if task.craft.thrusters.count:
        valves = SchmittLaw(task.craft, *reference)
        flown = fly_held_law(task.craft, task.start, valves, valves.shut, task.table)
    else:
        law = PDLaw(task.craft, *reference, clipped=clipped)
        flown = fly_law(task.craft, task.start, law, task.table)
    return jax.tree.map(np.asarray, flown)


def flown_controls(task: SlewTask, flown: Trajectory) -> Floats:
    """Controls (N, b) of a flight in the task's own axes [N m]."""
    wheel, thrust = flown.wheel_torque[: task.intervals], flown.thrust[: task.intervals]
    if task.axes == "body":
        return np.asarray(wheel @ np.asarray(task.craft.wheels.axes).T)
    return np.concatenate([wheel, thrust], axis=1)
