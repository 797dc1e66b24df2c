"""The parts of a spacecraft as pytrees; whatever computes with them takes them from here."""

from __future__ import annotations

import jax

from jaxatt.spacecraft.parts.battery import Battery as Battery
from jaxatt.spacecraft.parts.magnetorquers import Magnetorquers as Magnetorquers
from jaxatt.spacecraft.parts.panels import SolarPanels as SolarPanels
from jaxatt.spacecraft.parts.speed_bands import SpeedBands as SpeedBands
from jaxatt.spacecraft.parts.thrusters import Thrusters as Thrusters
from jaxatt.spacecraft.parts.vehicle import Spacecraft as Spacecraft
from jaxatt.spacecraft.parts.wheel_motor import WheelMotors as WheelMotors
from jaxatt.spacecraft.parts.wheels import ReactionWheels as ReactionWheels

for part in (Battery, Magnetorquers, SolarPanels, SpeedBands, Spacecraft, Thrusters, WheelMotors):
    jax.tree_util.register_dataclass(part)

jax.tree_util.register_dataclass(
    ReactionWheels,
    data_fields=[
        "axes",
        "inertia",
        "torque_limit",
        "speed_limit",
        "efficiency",
        "regeneration",
        "avoid",
        "motors",
    ],
    meta_fields=[],
    drop_fields=["mounted", "failed"],  # names: transformations forget them, and none recompiles
)
