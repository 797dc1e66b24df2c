"""The attitudes that a scenario prescribes, with the orbit frame at these instants."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from jaxatt.environment.table import environment_at
from jaxatt.problems.reading.pointing import Moment
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.surroundings import surroundings_of
from jaxatt.runtime.arrays import Floats


def moments_of(scenario: Scenario) -> list[Moment]:
    """Attitudes that a spacecraft's scenario prescribes, with the orbit frame then."""
    horizon, initial, passing = scenario.horizon, scenario.initial, scenario.waypoint
    asked: list[tuple[str, float, Floats, Floats, Floats | None]]
    asked = [("start", 0.0, initial.q_ob, initial.omega_ob, None)]
    if passing is not None:
        asked.append(("waypoint", passing.time, passing.q_ob, np.zeros(3), None))
    for index, target in enumerate(scenario.targets):
        label = "target" if len(scenario.targets) == 1 else f"target of leg {index + 1}"
        asked.append((label, (index + 1) * horizon.duration, *target.pose, target.boresight))
    times = jnp.asarray([time for _, time, *_ in asked])
    around = environment_at(surroundings_of(scenario), times)
    frames = zip(np.asarray(around.orbit_attitude), np.asarray(around.orbit_rate), strict=True)
    return [
        Moment(label, time, q_ob, omega_ob, *frame, axis)
        for (label, time, q_ob, omega_ob, axis), frame in zip(asked, frames, strict=True)
    ]
