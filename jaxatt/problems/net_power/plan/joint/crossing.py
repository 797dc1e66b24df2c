"""What a task of prescribed attitude does to the wheels' momentum, from flights of neighbours."""

from __future__ import annotations

import itertools
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Motion
from jaxatt.problems.net_power.plan.hold import fly_held
from jaxatt.problems.net_power.plan.joint.parameters import Crossing
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.from_flight import stored_of
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.task import rotation
from jaxatt.runtime.arrays import Floats

_AWAY = 0.02
"""[rad/s], of the momentum's coordinates between neighbours: some 10 rad/s of a wheel."""


def _faster(p: WheelsParameters, form: WheelsForm, change: Floats) -> Floats:
    """Change (n,) [rad/s] of wheel speeds that a change (k,) of the coordinates stands for."""
    inertia = np.asarray(p.wheel_inertia)
    if form.each:
        each: Floats = float(p.momentum_scale) * change / inertia
        return each
    taken = np.linalg.pinv(np.asarray(p.axes)) @ np.asarray(p.without_spin) @ change
    summed: Floats = taken / inertia
    return summed


def crossing(
    p: WheelsParameters, form: WheelsForm, manoeuvre: Manoeuvre, pose: Pose, end: Floats
) -> Crossing:
    """Crossing of a task near the state it was flown from.

    manoeuvre : of the task.  pose : to begin in, with the sign of the quaternion that the harvest
    before ends with.  end : (4,), attitude at the end, with the sign that the next one begins with.
    """
    k, speeds = form.stored, np.asarray(manoeuvre.start.omega_bw, float)
    steps = [np.zeros(k), *np.eye(k), *-np.eye(k)]
    pairs = list(itertools.combinations(range(k), 2))
    steps += [np.eye(k)[i] + np.eye(k)[j] for i, j in pairs]
    starts = [speeds + _faster(p, form, _AWAY * step) for step in steps]
    near = [replace(manoeuvre, start=Motion(pose.q_ib, pose.omega_ib, start)) for start in starts]
    flown = fly_held(near, np.tile(pose.omega_ib, (len(near), 1)))
    ends = stored_of(p, form, pose.omega_ib, flown.omega_bw[:, -1])
    # Signed power is a difference of kinetic energies, which the programme pays at its end.
    wheels = 0.0 if form.power == "signed" else flown.energy.wheels_J
    energy = wheels + flown.energy.magnetorquers_J - flown.energy.solar_J
    plus, minus = slice(1, 1 + k), slice(1 + k, 1 + 2 * k)
    mapping = ((ends[plus] - ends[minus]) / (2.0 * _AWAY)).T
    bend = np.diag(energy[plus] + energy[minus] - 2.0 * energy[0])
    for (i, j), both in zip(pairs, energy[1 + 2 * k :], strict=True):
        bend[i, j] = bend[j, i] = both - energy[1 + i] - energy[1 + j] + energy[0]
    values, vectors = np.linalg.eigh(bend / _AWAY**2)
    around = stored_of(p, form, pose.omega_ib, speeds)
    scale = float(p.energy_scale)
    found = {
        "begin": pose.q_ib,
        "end": end,
        "rate": pose.omega_ib,
        "mapping": mapping,
        "offset": ends[0] - mapping @ around,
        "turned": rotation(end) @ np.asarray(p.without_spin) / float(p.momentum_scale),
        "spent": energy[0] / scale,
        "slope": (energy[plus] - energy[minus]) / (2.0 * _AWAY * scale),
        "bend": vectors * np.maximum(values, 0.0) @ vectors.T / scale,
        "around": around,
        "drained": flown.energy.loads_J[0] / scale,
    }
    return Crossing(**{name: jnp.asarray(value) for name, value in found.items()})


def nothing_crossed(form: WheelsForm) -> Crossing:
    """A crossing for the stages that are intervals, which is not read."""
    k, still = form.stored, jnp.array([1.0, 0.0, 0.0, 0.0])
    line, square, none = jnp.zeros(k), jnp.zeros((k, k)), jnp.zeros(())
    return Crossing(
        still, still, jnp.zeros(3), square, line, jnp.zeros((3, 3)), none, line, square, line, none
    )
