"""Condense a staged programme to what decides it: controls and the free part of the first state."""

from __future__ import annotations

import numpy as np

from jaxatt.optimize.interior_point.model import Model
from jaxatt.optimize.sensitivity.conditions import Condensed


def condensed(model: Model, free_start: int) -> Condensed:
    """Second-order model in the decided coordinates of the first state (f,), then all controls.

    model : on the host.  The states follow from the dynamics, to first order; their curvature is in
    the Hessian of the Lagrangian.
    """
    count, n, width = model.dynamics.shape
    size = width - n
    total = free_start + count * size
    reach = np.zeros((n, total))
    reach[n - free_start :, :free_start] = np.eye(free_start)
    hessian, path, equality = np.zeros((total, total)), [], []
    for k in range(count):
        own = np.zeros((size, total))
        own[:, free_start + k * size : free_start + (k + 1) * size] = np.eye(size)
        moved = np.concatenate([reach, own])
        known = free_start + (k + 1) * size  # later controls do not matter yet
        part = moved[:, :known]
        hessian[:known, :known] += part.T @ model.hessian[k] @ part
        path.append(model.path_slope[k] @ moved)
        equality.append(model.equality_slope[k] @ moved)
        reach = np.asarray(model.dynamics[k]) @ moved
    hessian += reach.T @ model.final_hessian @ reach
    controls = np.eye(total)[free_start:]
    return Condensed(
        hessian,
        np.concatenate([*equality, model.rows_slope @ reach]),
        np.concatenate([*path, model.final_slope @ reach, controls, -controls]),
    )
