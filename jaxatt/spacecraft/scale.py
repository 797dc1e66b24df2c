"""What is small and what is large for a vehicle, so that nothing absolute decides about it.

A vehicle whose inertia, wheels, limits, momenta and disturbances are all multiplied by one factor
moves as before, with that many times the torques.
"""

from __future__ import annotations

import math

import numpy as np

from jaxatt.spacecraft.parts.vehicle import Spacecraft

IDLE_SHARE = 1e-6 / 3e-3
"""Share of its limit up to which an actuator counts as idle.

Schaanning (2021), definition 5.1.1, takes 1e-6 N m for wheels of 3e-3 N m.
"""


def largest_torque_limit(craft: Spacecraft) -> float:
    """Largest torque limit [N m] of a wheel or thruster; 0 where there are none."""
    limits = (craft.wheels.torque_limit, craft.thrusters.torque_limit)
    return max(float(np.max(np.asarray(limit), initial=0.0)) for limit in limits)


def least_torque_limit(craft: Spacecraft) -> float:
    """Smallest torque limit [N m] of a wheel or thruster; inf where there are none."""
    limits = (craft.wheels.torque_limit, craft.thrusters.torque_limit)
    return min(float(np.min(np.asarray(limit), initial=np.inf)) for limit in limits)


def inertia_unit(craft: Spacecraft) -> float:
    """Power of two next to the mean principal moment of J_s [kg m^2].

    Programmes that carry momenta or torques count them in it: the momentum then is about a rate.
    Dividing by a power of two rounds nothing.
    """
    mean = float(np.trace(np.asarray(craft.inertia_without_spin))) / 3.0
    return math.ldexp(1.0, round(math.log2(mean)))
