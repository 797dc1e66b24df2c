"""The slew as a system for sparse control."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np
from jax import Array

from jaxatt.environment.table import EnvironmentTable
from jaxatt.optimize.equations import Equations
from jaxatt.problems.hands_off.slew.model import (
    SlewForm,
    SlewParameters,
    bound_margins,
    terminal_rows,
    torque_margins,
)
from jaxatt.problems.hands_off.slew.pointing_path import path_margins
from jaxatt.problems.hands_off.slew.pulse_equations import pulse_equations
from jaxatt.problems.hands_off.slew.response import slew_response
from jaxatt.problems.hands_off.slew.stages import slew_stages
from jaxatt.problems.hands_off.slew.thruster_path import path_response, thruster_margins
from jaxatt.problems.hands_off.slew.thruster_response import thruster_response, thruster_rows
from jaxatt.problems.hands_off.sparse_program import DecidedBy, SparseSystem
from jaxatt.runtime.lengths import held_on


def _equations(
    form: SlewForm, u: Array, weights: Array, moved: Array, accurate: Array, p: SlewParameters
) -> Equations:
    return pulse_equations(u, weights, moved, accurate, p, form)


def _stretched(p: SlewParameters, ratio: Array) -> SlewParameters:
    table = replace(p.table, substep=p.table.substep * ratio)
    return replace(p, step=p.step * ratio, table=table)


def _lengthened(p: SlewParameters, more: int) -> SlewParameters:
    """Fill a slew up with intervals that take no time."""
    intervals = p.table.stages.gradient.shape[0]

    def along(length: Array) -> Any:
        return np.pad(np.full(intervals, float(length)), (0, more))

    stages, nodes = held_on(p.table.stages, more), held_on(p.table.nodes, more)
    table = EnvironmentTable(stages, nodes, along(p.table.substep))
    return replace(p, step=along(p.step), table=table)


@functools.cache
def slew_system(form: SlewForm) -> SparseSystem:
    """System for sparse control with the terms of `form` compiled in."""
    if form.has_thrusters:
        return SparseSystem(
            rows=lambda u, p: thruster_rows(u, p, form),
            margins=lambda u, p: thruster_margins(u, p, form),
            stage_margins=bound_margins,
            turned=lambda p, sign: replace(p, reference=p.reference * sign),
            stretched=_stretched,
            response=lambda u, p: thruster_response(u, p, form),
            bounds=lambda p: (p.lower, p.upper),
            path=(lambda u, p: path_response(u, p, form)) if form.pointed else None,
            decided_by=DecidedBy.BOUNDS,
            label=repr(form),
        )
    by_pulses = not (form.gyroscopic or form.path_limited)
    return SparseSystem(
        rows=lambda u, p: terminal_rows(u, p, form),
        margins=lambda u, p: path_margins(u, p, form),
        stage_margins=torque_margins,
        turned=lambda p, sign: replace(p, reference=p.reference * sign),
        aimed=lambda p, target: replace(p, reference=target),
        stretched=_stretched,
        lengthened=None if form.path_limited else _lengthened,
        response=None if form.path_limited else lambda u, p: slew_response(u, p, form),
        equations=functools.partial(_equations, form) if by_pulses else None,
        limits=lambda p: p.to_wheels,
        stages=functools.partial(slew_stages, form),
        decided_by=DecidedBy.STAGES if form.path_limited else DecidedBy.CONDENSED,
        label=repr(form),
    )
