"""Read the wheels, thrusters and magnetorquers of a vehicle."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.vehicle_part import TOML_NAMES, checked, part
from jaxatt.problems.reading.wheel_axes import read_wheel_axes
from jaxatt.problems.reading.wheel_speeds import read_avoid
from jaxatt.spacecraft.failed_wheels import loss_sentence, without
from jaxatt.spacecraft.parts.magnetorquers import Magnetorquers, magnetorquers
from jaxatt.spacecraft.parts.thrusters import Thrusters, thrusters
from jaxatt.spacecraft.parts.wheels import ReactionWheels, reaction_wheels

_MOTORS = ("coulomb", "viscous", "full_torque_speed", "no_torque_speed")
"""Arguments of `wheel_motors`."""


def read_wheels(vehicle: Table, notes: list[str]) -> ReactionWheels | None:
    """Read [vehicle.wheels]; None without it.

    notes : receives a line for each axis that was scaled to unit length, and one on what is left
        where wheels have failed.
    """
    if "wheels" not in vehicle:
        return None
    table = part(vehicle, "wheels")
    names = table.texts("names")
    failed = table.texts("failed")
    if set(table.data) == {"failed"}:
        table.fail("failed", "the vehicle has no wheels", "drop it")
    axes = read_wheel_axes(table)
    inertia = table.require("inertia_kgm2")
    limit = table.require("torque_limit_Nm")
    avoid = read_avoid(table, axes.shape[1])
    motors = {name: table.data[TOML_NAMES[name]] for name in _MOTORS if TOML_NAMES[name] in table}
    whole = checked(
        table,
        lambda: reaction_wheels(
            axes,
            inertia,
            limit,
            table.data.get("speed_limit_rad_s", np.inf),
            table.data.get("efficiency", 1.0),
            table.data.get("regeneration", 0.0),
            names=names,
            avoid=avoid,
            motors=motors,
            notes=notes,
        ),
    )
    if not failed:
        return whole
    left = checked(table, lambda: without(whole, failed))
    notes.append(loss_sentence(whole, left))
    return left


def read_thrusters(vehicle: Table) -> Thrusters | None:
    """Read [vehicle.thrusters]; None without it."""
    if "thrusters" not in vehicle:
        return None
    table = part(vehicle, "thrusters")
    directions = table.rows("torque_directions")
    limit = table.require("torque_limit_Nm")
    return checked(
        table,
        lambda: thrusters(
            directions,
            limit,
            table.data.get("minimum_on_time_s", 0.0),
            table.data.get("minimum_impulse_Nms", 0.0),
        ),
    )


def read_magnetorquers(vehicle: Table, notes: list[str]) -> Magnetorquers | None:
    """Read [vehicle.magnetorquers]; None without it.

    notes : receives a line where they act for a share of the time only.
    """
    if "magnetorquers" not in vehicle:
        return None
    table = part(vehicle, "magnetorquers")
    limit = table.require("dipole_limit_Am2")
    built = checked(
        table,
        lambda: magnetorquers(
            limit,
            table.data.get("full_power_W"),
            table.data.get("turns"),
            table.data.get("coil_area_m2"),
            table.data.get("resistance_ohm"),
            table.data.get("duty", 1.0),
        ),
    )
    if built.duty != 1.0:
        most = ", ".join(f"{each:.4g}" for each in built.dipole_limit)
        notes.append(
            f"the magnetorquers act for {built.duty:g} of every period: dipoles are means over "
            f"it, at most ({most}) A m^2"
        )
    return built
