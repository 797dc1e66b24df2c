"""Starts of a reorientation, as the solver takes them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats


class Paths(NamedTuple):
    """Starts of a reorientation; leading axis S.

    u : (S, N, b), scaled controls.  states : (S, N + 1, s), of the programme.
    step : (S,) [s].  reference : (S, 3 or 4), target attitude the way that the start goes.
    effort_weight : (S,) [1/(N m)^2], rho.
    """

    u: Floats
    states: Floats
    step: Floats
    reference: Floats
    effort_weight: Floats


def states_along(
    task: ReorientationTask, q: Floats, omega: Floats, momentum: Floats, u: Floats, step: Floats
) -> Floats:
    """States of the programme at all nodes, (S, N + 1, s).

    q : (S, N + 1, 4), attitudes.  omega : (S, N + 1, 3) [rad/s].  momentum : (S, N + 1, 3) [N m s],
    total, in body axes.  u : (S, N, b), scaled controls.  step : (S,) [s].
    """
    form = task.form
    attitude = q
    if form.body.attitude == "mrp":
        attitude = q[..., 1:] / np.maximum(1.0 + q[..., :1], 1e-300)
        size = np.linalg.norm(attitude, axis=-1, keepdims=True)
        # The other set, where the solver's own steps change to it.
        beyond = size > form.body.largest_mrp
        attitude = np.where(beyond, -attitude / np.where(beyond, size, 1.0) ** 2, attitude)
    parts = [attitude, omega]
    if form.body.momentum == "carried":
        parts.append(momentum / task.unit)
    if form.carries_impulses:
        spent = np.cumsum(u * step[:, None, None], axis=1)
        parts.append(np.concatenate([np.zeros_like(u[:, :1]), spent], axis=1))
    parts.append(np.broadcast_to(np.log(step)[:, None, None], (*q.shape[:2], 1)))
    return np.concatenate(parts, axis=-1)
