"""One programme's parameters and start from the tasks of a plan as they were flown in sequence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.plan.joint.crossing import crossing, nothing_crossed
from jaxatt.problems.net_power.plan.joint.parameters import JointParameters, JointStage
from jaxatt.problems.net_power.plan.manoeuvre import asked_pose
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.from_flight import INSIDE, dipoles_of, states_of
from jaxatt.problems.net_power.wheels.host import continuous
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.starts import with_powers
from jaxatt.problems.net_power.wheels.task import WheelsTask, wheel_ranges, wheels_task
from jaxatt.runtime.arrays import Floats

_ROOM = 1e-3
"""By which magnitudes of power begin above what they have to be at least."""


@dataclass(frozen=True, eq=False)
class Leg:
    """A task as it was flown.

    q_ib (N + 1, 4), omega_ib (N + 1, 3) and omega_bw (N + 1, n) [rad/s], at its nodes.
    torque : (N, n) [N m] and dipole : (N, 3) [A m^2], of a harvest; None where it is not decided.
    """

    task: Task
    manoeuvre: Manoeuvre
    q_ib: Floats
    omega_ib: Floats
    omega_bw: Floats
    torque: Floats | None = None
    dipole: Floats | None = None


@dataclass(frozen=True, eq=False)
class Assembled:
    """A plan as the solver sees it.

    controls : (K, b) and states : (K + 1, s), to start from.  intervals : of each leg the slice of
    its stages; of a task of prescribed attitude it has one.
    """

    form: WheelsForm
    parameters: JointParameters
    controls: Floats
    states: Floats
    intervals: tuple[slice, ...]


def assembled(legs: Sequence[Leg], substeps: int) -> Assembled:
    """Join the legs of a plan, of which one at least is a harvest.

    substeps : steps of the motion an interval.
    """
    open_ended = [
        wheels_task(replace(leg.manoeuvre, end=None), substeps) if leg.task.searched else None
        for leg in legs
    ]
    harvests = [task for task in open_ended if task is not None]
    form, p = _common(harvests), harvests[0].parameters
    stages: list[Any] = []
    controls: list[Floats] = []
    states: list[Floats] = []
    intervals: list[slice] = []
    before = 0
    for index, (leg, task) in enumerate(zip(legs, open_ended, strict=True)):
        q = continuous(leg.q_ib)
        if index and states[-1][-1, :4] @ q[0] < 0.0:
            q = -q
        count = 1 if task is None else leg.task.intervals
        if task is None:
            stages.append(_across(p, form, leg, q, harvests[0]))
            controls.append(np.full((1, form.controls), _ROOM))
            controls[-1][:, : form.wheels] = 0.0
            rows = slice(0, None, len(q) - 1)
        else:
            stages.append(_intervals(task, form))
            rows = slice(None)
        state = states_of(p, form, q[rows], leg.omega_ib[rows], leg.omega_bw[rows])
        if task is not None:
            controls.append(_controls(task, form, state, leg))
        if form.charge:
            state = np.concatenate([state, np.zeros((len(state), 1))], axis=1)
        states.append(state)
        intervals.append(slice(before, before + count))
        before += count
    whole = [state[:-1] for state in states] + [states[-1][-1:]]
    x = np.concatenate(whole)
    start = x[0].copy()
    if form.charge:
        start[-1] = float(legs[0].manoeuvre.charge) / float(p.energy_scale)
        x[:, -1] = start[-1]
    last = open_ended[-1]
    wheels = replace(
        p,
        start=start,
        last_shone=0.0 * p.last_shone if last is None else last.parameters.last_shone,
        last_sun=p.last_sun if last is None else last.parameters.last_sun,
    )
    joined = jax.tree.map(lambda *leaves: jnp.concatenate(leaves), *stages)
    return Assembled(
        form, JointParameters(wheels, joined), np.concatenate(controls), x, tuple(intervals)
    )


def _common(harvests: Sequence[WheelsTask]) -> WheelsForm:
    """The form of all harvests; a momentum that is zero for some is constant for all."""
    forms = {task.form.momentum for task in harvests}
    form = harvests[0].form
    return form if len(forms) == 1 else replace(form, momentum="constant")


def _controls(task: WheelsTask, form: WheelsForm, states: Floats, leg: Leg) -> Floats:
    """Controls (N, b) of the programme, with magnitudes of power a little above the least ones."""
    p, torque = task.parameters, leg.torque
    assert torque is not None
    scaled = np.clip(torque / np.asarray(p.torque_limit), -INSIDE, INSIDE)
    dipoles = None if leg.dipole is None else dipoles_of(p, leg.dipole)[None]
    scale, total = np.asarray(p.power_scale)[None], np.asarray(p.total)[None]
    common = replace(task, form=form)
    whole = with_powers(common, total, scale, states[None], scaled[None], dipoles, _ROOM)
    found: Floats = whole[0]
    return found


def _intervals(task: WheelsTask, form: WheelsForm) -> JointStage:
    """Stages of a harvest."""
    p, count = task.parameters, task.manoeuvre.intervals
    return JointStage(
        crossing=jnp.zeros(count),
        interval=jax.tree.map(jnp.asarray, p.stages),
        across=_repeated(nothing_crossed(form), count),
        load=jnp.full(count, float(p.load)),
        **_repeated(_limits(task.manoeuvre), count),
    )


def _across(
    p: WheelsParameters,
    form: WheelsForm,
    leg: Leg,
    q: Floats,
    harvest: WheelsTask,
) -> JointStage:
    """Stage of a task of prescribed attitude; q : (M, 4), its attitudes."""
    asked = asked_pose(leg.task, leg.manoeuvre.start)
    sign = -1.0 if asked.q_ib @ q[0] < 0.0 else 1.0
    pose = Pose(sign * asked.q_ib, asked.omega_ib)
    end = pose.after(leg.task.duration).q_ib
    end = -end if end @ q[-1] < 0.0 else end
    idle = jax.tree.map(lambda leaf: jnp.asarray(leaf)[:1], harvest.parameters.stages)
    return JointStage(
        crossing=jnp.ones(1),
        interval=idle._replace(shone=jnp.zeros(1)),
        across=_repeated(crossing(p, form, leg.manoeuvre, pose, end), 1),
        load=jnp.zeros(1),
        **_repeated(_limits(leg.manoeuvre), 1),
    )


def _limits(manoeuvre: Manoeuvre) -> dict[str, Floats]:
    """Limits of the wheels, which depend on where their speeds begin."""
    lower, upper, share = wheel_ranges(manoeuvre, np.asarray(manoeuvre.start.omega_bw, float))
    return {"speed_lower": lower, "speed_upper": upper, "motor_limit": share}


def _repeated(tree: Any, count: int) -> Any:
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (count, *np.shape(leaf))), tree)
