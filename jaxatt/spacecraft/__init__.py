"""Spacecraft: rigid body, actuators, solar panels and battery."""

from jaxatt.spacecraft.battery import Battery, battery, charge_along
from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.magnetorquers import Magnetorquers, magnetorquers
from jaxatt.spacecraft.panels import SolarPanels, collecting_area, solar_panels
from jaxatt.spacecraft.thrusters import Thrusters, thrusters
from jaxatt.spacecraft.vehicle import Spacecraft, create, total_momentum
from jaxatt.spacecraft.wheels import ReactionWheels, momentum, reaction_wheels

__all__ = [
    "Battery",
    "FieldError",
    "Magnetorquers",
    "ReactionWheels",
    "SolarPanels",
    "Spacecraft",
    "Thrusters",
    "battery",
    "charge_along",
    "collecting_area",
    "create",
    "magnetorquers",
    "momentum",
    "reaction_wheels",
    "solar_panels",
    "thrusters",
    "total_momentum",
]
