from .battery import Battery, battery, charge_along
from .checks import FieldError
from .magnetorquers import Magnetorquers, magnetorquers
from .panels import SolarPanels, collecting_area, solar_panels
from .thrusters import Thrusters, thrusters
from .vehicle import Spacecraft, create, total_momentum
from .wheels import ReactionWheels, momentum, reaction_wheels

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
