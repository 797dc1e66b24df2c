"""What flies in a fine flight, the same for all manoeuvres that are flown together."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.problems.net_power.flight_lanes import Plant
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.simulation.magnetic_action import momentum_hold
from jaxatt.simulation.powers import Powers


def plant_of(manoeuvre: Manoeuvre) -> Plant:
    """What flies in a manoeuvre, as the flights need it."""
    satellite = manoeuvre.satellite
    craft, management = satellite.craft, satellite.momentum
    hold = None
    if management is not None:
        if craft.magnetorquers is None:
            raise ValueError("momentum: the vehicle has no magnetorquers to manage it with")
        speed = jnp.asarray(management.wheel_speed)
        law = MomentumDumping(management.gain, speed, printed=True)
        hold = momentum_hold(craft, craft.magnetorquers, law)
    powers = Powers(craft, satellite.light.irradiance, satellite.wheel_power)
    return Plant(powers, satellite.torques, hold)


def common_plant(manoeuvres: Sequence[Manoeuvre]) -> Plant:
    """What flies in all of several manoeuvres.

    Raises `ValueError` where it is not the same satellite; orbits, dates and light may differ.
    """
    plant = plant_of(manoeuvres[0])
    leaves, tree = jax.tree.flatten(plant)
    seen = {id(manoeuvres[0].satellite)}
    for number, other in enumerate(manoeuvres):
        if id(other.satellite) in seen:
            continue
        seen.add(id(other.satellite))
        its, its_tree = jax.tree.flatten(plant_of(other))
        same = str(tree) == str(its_tree) and all(map(np.array_equal, leaves, its))
        if not same:
            raise ValueError(
                f"satellite: manoeuvre {number} is flown by another satellite than manoeuvre 0 "
                "(vehicle, external torques, momentum management, wheel power or irradiance "
                "differ); fly them one after the other"
            )
    return plant


def common_intervals(manoeuvres: Sequence[Manoeuvre]) -> int:
    """Number of intervals of several manoeuvres; raises `ValueError` where it is not the same."""
    counts = {manoeuvre.intervals for manoeuvre in manoeuvres}
    if len(counts) > 1:
        raise ValueError(
            f"intervals: manoeuvres flown together must have the same number, not {sorted(counts)}"
        )
    return counts.pop()
