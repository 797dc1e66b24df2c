"""Spacecraft: rigid body and reaction wheels."""

from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.vehicle import Spacecraft, create, total_momentum
from jaxatt.spacecraft.wheels import ReactionWheels, momentum, reaction_wheels

__all__ = [
    "FieldError",
    "ReactionWheels",
    "Spacecraft",
    "create",
    "momentum",
    "reaction_wheels",
    "total_momentum",
]
