"""Cases that the comparison runs, by name."""

from __future__ import annotations

import numpy as np

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.toy.build import build_toy

HALF_TORQUE = "-half-torque"
"""Ending of a case's name: the same slew with every wheel's torque limit halved."""

BEST_KNOWN = {
    "hypso1-90-45-15": 2,
    "hypso1-75-50-15": 2,
    "hypso1-90-45-15-half-torque": 2,
    "hypso1-75-50-15-half-torque": 2,
    "eseo-1": 10,
    "eseo-2": 20,
    "eseo-3": 10,
    # The least effort is 1.837722 s and the impulse -1 s, so at least 1.418861 s push one way and
    # 0.418861 s the other: 29 and 9 intervals of 0.05 s.
    "double-integrator": 38,
}
"""Best-known number of active intervals."""


def scenario_of(case: str) -> Scenario:
    """Scenario of a case.  Raises KeyError for a name that is not in `BEST_KNOWN`."""
    if case not in BEST_KNOWN:
        raise KeyError(f"{case}: choose one of {', '.join(BEST_KNOWN)}")
    scenario = scenarios.load(case.removesuffix(HALF_TORQUE))
    if not case.endswith(HALF_TORQUE):
        return scenario
    assert scenario.vehicle is not None
    limit = np.asarray(scenario.vehicle.wheels.torque_limit) / 2.0
    return scenarios.replace(scenario, {"vehicle.wheels.torque_limit_Nm": limit.tolist()})


def task_of(case: str) -> SparseTask:
    """SparseTask of a case; `jax_enable_x64` must be on."""
    scenario = scenario_of(case)
    return build_toy(scenario) if scenario.vehicle is None else build_slew(scenario)
