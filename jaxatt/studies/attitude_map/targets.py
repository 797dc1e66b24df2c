"""Targets of a map: attitudes spread evenly over all turns from the initial one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.attitude.uniform_rotations import uniform_rotations
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.registry import family_of
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats

MOST = 10_000_000
"""Targets of one map, at most."""


@dataclass(frozen=True, eq=False)
class MapTargets:
    """Targets of a map.

    q_ob : (M, 4), as the scenario's own target.  axis : (M, 3), unit vectors in body axes, and
    angle : (M,) [rad], of 0 to pi, of the turn from the scenario's initial attitude.
    """

    q_ob: Floats
    axis: Floats
    angle: Floats


def map_targets(scenario: Scenario, count: int) -> MapTargets:
    """Spread targets over all turns from the initial attitude; the same for the same count.

    Raises `ScenarioError` where the scenario has not one attitude that it aims at.
    """
    if not 1 <= count <= MOST:
        raise ScenarioError(f"targets = {count}: must be 1 to {MOST}; give another number")
    if not family_of(scenario).mapped or len(scenario.targets) != 1:
        has = f"has {len(scenario.targets)} targets" if scenario.vehicle else "is no spacecraft's"
        raise ScenarioError(
            f"{scenario.name}: {has}, and a map turns the one attitude that is aimed at; choose a "
            "scenario with one [target]"
        )
    if scenario.leaves_roll_free:
        raise ScenarioError(
            f"{scenario.name}: [target] leaves the roll free, and a map turns whole attitudes; add "
            "constrain beside align"
        )
    turn = uniform_rotations(count)
    size = np.linalg.norm(turn[:, 1:], axis=1)
    q = np.asarray(quaternion.multiply(np.asarray(scenario.initial.q_ob), turn))
    return MapTargets(q, turn[:, 1:] / size[:, None], 2.0 * np.arctan2(size, turn[:, 0]))
