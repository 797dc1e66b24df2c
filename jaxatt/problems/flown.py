"""The first of some flights of a spacecraft, as a record holds it."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.manoeuvre import InitialState
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory


def flown_series(flown: Trajectory) -> dict[str, Floats]:
    """Attitude, rates and wheel speeds at the nodes of the first of S flights."""
    return {
        "q_ob": np.asarray(flown.q_ob[0]),
        "omega_ob": np.asarray(flown.omega_ob[0]),
        "omega_ib": np.asarray(flown.omega_ib[0]),
        "omega_bw": np.asarray(flown.omega_bw[0]),
    }


def flown_end(flown: Trajectory, node: int) -> InitialState:
    """State at a node of the first of S flights, where the next phase begins."""
    ends = (flown.q_ob, flown.omega_ob, flown.omega_bw)
    return InitialState(*(np.asarray(part[0, node]) for part in ends))
