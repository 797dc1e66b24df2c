"""Spacecraft: rigid body, reaction wheels and thrusters."""

from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.thrusters import Thrusters, thrusters
from jaxatt.spacecraft.vehicle import Spacecraft, create, total_momentum
from jaxatt.spacecraft.wheels import ReactionWheels, momentum, reaction_wheels

__all__ = [
    "FieldError",
    "ReactionWheels",
    "Spacecraft",
    "Thrusters",
    "create",
    "momentum",
    "reaction_wheels",
    "thrusters",
    "total_momentum",
]
