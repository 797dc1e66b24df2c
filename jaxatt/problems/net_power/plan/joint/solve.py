"""Solve all tasks of a plan together, from the plan as it was flown in sequence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.plan.joint.assemble import Assembled, Leg, assembled
from jaxatt.problems.net_power.plan.joint.programme import joint_programme
from jaxatt.problems.net_power.wheels.batch import settings_for
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_BARRIER = 1e-4
"""The first one, for a start that is nearly optimal."""


@dataclass(frozen=True, eq=False)
class JointAnswer:
    """Answer to a whole plan.

    torque : (N, n) [N m] of each harvest, None for the other tasks.
    dipole : (N, 3) [A m^2] likewise, where it was decided.
    status : of the solver.  violation, stationarity : at its end.  iterations : passes.
    """

    torque: tuple[Floats | None, ...]
    dipole: tuple[Floats | None, ...]
    status: Status
    violation: float
    stationarity: float
    iterations: int


@dataclass(frozen=True)
class _Job:
    """Static part of the solve, as `run_starts` needs it."""

    form: WheelsForm

    @property
    def label(self) -> str:
        """Label for `jaxatt.runtime.compilation`."""
        return f"net power, all tasks, {self.form}"

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        return joint_programme(self.form)

    def enter(self, start: tuple[Any, Any], args: Any) -> tuple[Any, Any]:
        """The start, and the arguments."""
        return tuple(map(jnp.asarray, start)), args


def solve_jointly(
    legs: Sequence[Leg],
    substeps: int,
    settings: InteriorSettings | None = None,
    report: Report | None = None,
) -> JointAnswer:
    """Solve the plan once, starting from its tasks as flown.

    substeps : steps of the motion an interval.
    settings : of the solver; None for those of one harvest, from a smaller barrier.
    """
    plan = assembled(legs, substeps)
    settings = settings or replace(settings_for(plan.form), barrier=_BARRIER)
    found: InteriorSolution = run_starts(
        InteriorPoint(settings),
        _Job(plan.form),
        (plan.controls[None], plan.states[None]),
        plan.parameters,
        rows=1,
        progress=None if report is None else lambda done: report("improving all tasks", done),
    )
    return JointAnswer(
        *_decided(plan, legs, np.asarray(found.u[0])),
        Status(int(found.status[0])),
        float(found.violation[0]),
        float(found.stationarity[0]),
        int(found.iterations[0]),
    )


def _decided(
    plan: Assembled, legs: Sequence[Leg], u: Floats
) -> tuple[tuple[Floats | None, ...], tuple[Floats | None, ...]]:
    """Torques and dipoles of the harvests."""
    form, wheels = plan.form, plan.parameters.wheels
    torque: list[Floats | None] = []
    dipole: list[Floats | None] = []
    for leg, own in zip(legs, plan.intervals, strict=True):
        rows = u[own] if leg.task.searched else None
        both = None if rows is None or not form.dipoles else rows[:, form.controls - form.dipoles :]
        torque.append(None if rows is None else rows[:, : form.wheels] * wheels.torque_limit)
        dipole.append(None if both is None else (both[:, :3] - both[:, 3:]) * wheels.dipole_limit)
    return tuple(torque), tuple(dipole)
