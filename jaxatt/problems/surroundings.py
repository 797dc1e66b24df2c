"""Orbit and known disturbances of a scenario, as the environment's tables need them."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.environment import KeplerianElements
from jaxatt.environment.motion import Motion, TwoBody
from jaxatt.environment.table import Surroundings
from jaxatt.problems.scenario import Orbit, Scenario


def _array(value: Any) -> Any:
    """Array on the host: whoever only looks at it compiles nothing."""
    return np.asarray(value)


def elements_of(orbit: Orbit) -> KeplerianElements:
    """Osculating Keplerian elements at time zero."""
    return KeplerianElements(
        *(
            _array(value)
            for value in (
                orbit.semi_major_axis,
                orbit.eccentricity,
                orbit.inclination,
                orbit.raan,
                orbit.argument_of_periapsis,
                orbit.true_anomaly,
            )
        )
    )


def motion_of(orbit: Orbit) -> Motion:
    """Motion along an orbit, from time zero on: sampled, or an ellipse."""
    if orbit.path is not None and orbit.motion is None:
        raise ValueError("orbit: is no ellipse and was not sampled; call `covering` first")
    return orbit.motion or TwoBody(elements_of(orbit), _array(orbit.gravitational_parameter))


def surroundings_of(scenario: Scenario) -> Surroundings:
    """Orbit and known disturbances of a spacecraft's scenario."""
    orbit, disturbances = scenario.orbit, scenario.disturbances
    return Surroundings(
        None if orbit is None else motion_of(orbit),
        _array(float(disturbances.gravity_gradient)),
        _array(disturbances.sinusoidal_torque),
        _array(disturbances.sinusoidal_frequency),
    )
