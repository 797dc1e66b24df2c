"""Spacecraft: rigid body, reaction wheels, thrusters and magnetorquers."""

from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.magnetorquers import Magnetorquers, magnetorquers
from jaxatt.spacecraft.thrusters import Thrusters, thrusters
from jaxatt.spacecraft.vehicle import Spacecraft, create, total_momentum
from jaxatt.spacecraft.wheels import ReactionWheels, momentum, reaction_wheels

__all__ = [
    "FieldError",
    "Magnetorquers",
    "ReactionWheels",
    "Spacecraft",
    "Thrusters",
    "create",
    "magnetorquers",
    "momentum",
    "reaction_wheels",
    "thrusters",
    "total_momentum",
]
