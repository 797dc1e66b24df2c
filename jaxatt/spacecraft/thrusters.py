"""On/off thrusters: valves whose torque has one direction and cannot be reversed."""

from __future__ import annotations

from jaxatt.spacecraft.parts.thrusters import missing_senses as missing_senses
from jaxatt.spacecraft.parts.thrusters import no_thrusters as no_thrusters
from jaxatt.spacecraft.parts.thrusters import thrusters as thrusters
from jaxatt.spacecraft.pytrees import Thrusters as Thrusters
