"""Cost of active intervals and of partly open valves in the sources' objectives."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.hands_off.sparsity import complementarity_vector
from jaxatt.problems.hands_off.task import Goal
from jaxatt.runtime.arrays import Floats


def support_cost(controls: Floats, goal: Goal, weight: Floats) -> Floats:
    """Weighted sum of 1 - xi over intervals, and over axes for designs 2 and 3, (S,).

    controls : (S, N, b).  weight : (N,).
    Source: Schaanning (2021), eqs. (5.3), (5.5), (5.14) and (5.15).
    """
    shared = goal.design == 1
    xi = complementarity_vector(controls, goal.epsilon, shared)
    support = (weight if shared else weight[:, None]) * (1.0 - xi)
    cost = support.reshape(len(controls), -1).sum(axis=1)
    # Design 3 (5.15) counts 1 - (xi_1 + xi_2 + xi_3), less than design 2 by 2 an interval.
    return cost - 2.0 * controls.shape[1] if goal.design == 3 else cost


def partly_open(controls: Floats, thrust: Floats, limit: Floats, goal: Goal) -> Floats:
    """Sum of t (limit - t) over the thrusters of active intervals, or of idle ones, (S,).

    controls : (S, N, b), of all actuators.  thrust : (S, N, m) [N m], t.  limit : (m,) [N m].
    Source: Kristiansen and Gravdahl (2023), eq. 11.  As printed the factor is xi, which is zero
    wherever a thruster fires; the text describes 1 - xi.
    """
    xi = complementarity_vector(controls, goal.epsilon)
    factor = xi if goal.weights.on_off_idle else 1.0 - xi
    return np.asarray((factor * (thrust * (limit - thrust)).sum(axis=-1)).sum(axis=-1))
