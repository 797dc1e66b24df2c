from . import frames, kepler, orbit
from .gravity_gradient import gravity_gradient_torque
from .kepler import KeplerianElements
from .orbit import MU_EARTH
from .sinusoidal import sinusoidal_torque

__all__ = [
    "MU_EARTH",
    "KeplerianElements",
    "frames",
    "gravity_gradient_torque",
    "kepler",
    "orbit",
    "sinusoidal_torque",
]
