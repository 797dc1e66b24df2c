"""Spacecraft: rigid body, reaction wheels and magnetorquers."""

from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.magnetorquers import Magnetorquers, magnetorquers
from jaxatt.spacecraft.vehicle import Spacecraft, create, total_momentum
from jaxatt.spacecraft.wheels import ReactionWheels, momentum, reaction_wheels

__all__ = [
    "FieldError",
    "Magnetorquers",
    "ReactionWheels",
    "Spacecraft",
    "create",
    "magnetorquers",
    "momentum",
    "reaction_wheels",
    "total_momentum",
]
