"""Read the satellite of a scenario of net power, and what surrounds it."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from jaxatt.environment import igrf
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.eddy_currents import EddyCurrents
from jaxatt.environment.epoch import decimal_year
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.problems.net_power.manoeuvre import MomentumManagement, Satellite
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.dates import (
    MAGNETIC_FIELD,
    SUNLIGHT,
    check_epoch,
    moment_of,
)
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.light import read_light
from jaxatt.problems.reading.wheel_speeds import read_wheel_speeds
from jaxatt.problems.scenario import Orbit
from jaxatt.problems.surroundings import motion_of
from jaxatt.spacecraft import Spacecraft


def read_satellite(
    document: dict[str, Any],
    origin: str,
    craft: Spacecraft,
    orbit: Orbit | None,
    wheel_power: str,
    horizon: float,
) -> Satellite:
    """Read light, disturbances and the use of the magnetorquers.

    horizon : [s], within which the field model and the sun must hold.
    Raises `ScenarioError`.
    """
    if craft.panels is None:
        raise ScenarioError(
            f"{origin}: [vehicle.panels]: missing, and without panels no power can be earned; add "
            "it with normals, area_m2 and efficiency"
        )
    light = read_light(document.get("light", {}), origin, orbit)
    torques, gradient = _disturbances(document.get("disturbances", {}), origin, orbit)
    momentum, decided = _magnetorquing(document.get("magnetorquing", {}), origin, craft, orbit)
    magnetic = torques.magnetic or momentum is not None or decided or not craft.wheels.count
    task = None
    if orbit is not None:
        needs = {}
        if magnetic:
            needs[MAGNETIC_FIELD] = "a magnetic torque"
        if light.sun is None:
            needs[SUNLIGHT] = "[light] without sun_inertial"
        dated = Table(document["orbit"], origin, "[orbit]", NET_POWER_TABLES["orbit"])
        check_epoch(dated, orbit.days, horizon, needs)
        task = _orbit_task(orbit, magnetic)
    return Satellite(
        craft=craft,
        light=light,
        orbit=task,
        torques=torques,
        gravity_gradient=gradient,
        momentum=momentum,
        wheel_power=wheel_power,
        decided_dipole=decided or not craft.wheels.count,
    )


def _orbit_task(orbit: Orbit, magnetic: bool) -> OrbitTask:
    """Orbit with the field at its epoch, where anything magnetic acts."""
    days = 0.0 if orbit.days is None else orbit.days
    return OrbitTask(
        motion=motion_of(orbit),
        days=days,
        field=igrf.at_year(decimal_year(moment_of(days))) if magnetic else None,
    )


def _disturbances(data: Any, origin: str, orbit: Orbit | None) -> tuple[ExternalTorques, bool]:
    table = Table(data, origin, "[disturbances]", NET_POWER_TABLES["disturbances"])
    gradient = table.flag("gravity_gradient")
    dipole = table.vector("residual_dipole_Am2")
    eddy = table.number("eddy_coefficient")
    if orbit is None and (gradient or dipole.any() or eddy):
        key = next(key for key in table.data if key in table)
        table.fail(key, "there is no [orbit]", "add one, or drop the disturbances")
    return ExternalTorques(
        residual_dipole=ResidualDipole(jnp.asarray(dipole)) if dipole.any() else None,
        eddy_currents=EddyCurrents(eddy) if eddy else None,
    ), gradient


def _magnetorquing(
    data: Any, origin: str, craft: Spacecraft, orbit: Orbit | None
) -> tuple[MomentumManagement | None, bool]:
    """Read how the magnetorquers are used beside the wheels."""
    table = Table(data, origin, "[magnetorquing]", NET_POWER_TABLES["magnetorquing"])
    default = "decided" if not craft.wheels.count else "none"
    mode = table.choice("mode", default)
    if not craft.wheels.count and mode != "decided":
        table.fail("mode", "the vehicle has no wheels", 'use "decided" or leave it out')
    if mode == "none":
        return None, False
    if craft.magnetorquers is None:
        table.fail("mode", "the vehicle has no magnetorquers", "add [vehicle.magnetorquers]")
    if orbit is None:
        table.fail("mode", "there is no [orbit], so no magnetic field", "add [orbit] with an epoch")
    if mode == "decided":
        return None, True
    return MomentumManagement(
        gain=table.number("gain"),
        wheel_speed=read_wheel_speeds(table, craft.wheels),
    ), False
