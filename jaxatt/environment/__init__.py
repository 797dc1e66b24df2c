"""Orbit, orbit frame and disturbing torques."""

from jaxatt.environment import frames, kepler, orbit
from jaxatt.environment.gravity_gradient import gravity_gradient_torque
from jaxatt.environment.kepler import KeplerianElements
from jaxatt.environment.orbit import MU_EARTH
from jaxatt.environment.sinusoidal import sinusoidal_torque

__all__ = [
    "MU_EARTH",
    "KeplerianElements",
    "frames",
    "gravity_gradient_torque",
    "kepler",
    "orbit",
    "sinusoidal_torque",
]
