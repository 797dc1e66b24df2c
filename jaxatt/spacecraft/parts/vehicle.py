"""A rigid body with actuators, solar panels and a battery."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, brief, finite_array
from jaxatt.spacecraft.inertia import checked_inertia
from jaxatt.spacecraft.parts.array import Array
from jaxatt.spacecraft.parts.battery import Battery
from jaxatt.spacecraft.parts.magnetorquers import Magnetorquers
from jaxatt.spacecraft.parts.panels import SolarPanels
from jaxatt.spacecraft.parts.thrusters import Thrusters, missing_senses, no_thrusters
from jaxatt.spacecraft.parts.wheels import ReactionWheels, no_wheels


@dataclass(frozen=True, eq=False)
class Spacecraft:
    """A rigid body with actuators; build it with `create`, which checks the numbers.

    Attributes
    ----------
    inertia : (3, 3) array [kg m^2]
        Total inertia J in body axes, wheels included; Schaanning (2021), eq. 4.7.
    wheels : ReactionWheels
    name : str
        Static: two vehicles with different names are traced separately.
    thrusters : Thrusters
    magnetorquers : Magnetorquers or None
        None where the vehicle has none.
    panels : SolarPanels or None
    battery : Battery or None
    loads : dict of str to float [W]
        Power of everything but the actuators, by mode of operation.
    """

    inertia: Array
    wheels: ReactionWheels
    name: str = field(default="spacecraft", metadata={"static": True})
    thrusters: Thrusters = field(default_factory=no_thrusters)
    magnetorquers: Magnetorquers | None = None
    panels: SolarPanels | None = None
    battery: Battery | None = None
    loads: Mapping[str, Array | float] = field(default_factory=dict)

    @property
    def actuators(self) -> int:
        """Number of wheels and thrusters; arrays over both list the wheels first."""
        return self.wheels.count + self.thrusters.count

    @property
    def inertia_without_spin(self) -> Array:
        """Inertia J_s = J - A Jw A', (3, 3) [kg m^2]; Schaanning (2021), eq. 4.7.

        The inertia that a wheel torque accelerates: wheels count, but not about their own axes.
        """
        return self.inertia - self.wheels.spin_inertia_body


def create(
    inertia: Any,
    wheels: ReactionWheels | None,
    name: str = "spacecraft",
    thrusters: Thrusters | None = None,
    magnetorquers: Magnetorquers | None = None,
    panels: SolarPanels | None = None,
    battery: Battery | None = None,
    loads: Mapping[str, float] | None = None,
    *,
    notes: list[str] | None = None,
) -> Spacecraft:
    """Return a checked spacecraft.

    Parameters
    ----------
    inertia : (3, 3) array_like [kg m^2]
        Total inertia in body axes, wheels included.
    wheels : ReactionWheels or None
        As built by `reaction_wheels`.
    name : str
    thrusters : Thrusters, optional
        As built by `thrusters`.
    magnetorquers : Magnetorquers, optional
        As built by `magnetorquers`.
    panels : SolarPanels, optional
        As built by `solar_panels`.
    battery : Battery, optional
        As built by `battery`.
    loads : dict of str to float [W], optional
    notes : list of str, optional
        Receives a line where only the rounding of the inertia makes it that of no body.

    Raises
    ------
    FieldError
        A `ValueError` that names the field, the value and what is allowed.
    """
    total = checked_inertia(inertia, [] if notes is None else notes)
    if wheels is None and thrusters is None and magnetorquers is None:
        raise FieldError(
            "wheels",
            "missing, and there are no thrusters and no magnetorquers; mount one of the three",
        )
    if wheels is None and thrusters is not None:
        missing = missing_senses(np.asarray(thrusters.distribution))
        if missing:
            raise FieldError(
                "torque_directions",
                f"no combination of the {thrusters.count} thrusters turns the body about "
                f"{', '.join(missing)}; add or tilt a thruster so that every axis can be turned "
                "about in both senses, or mount wheels",
            )
    craft = Spacecraft(
        total,
        wheels or no_wheels(),
        name,
        thrusters or no_thrusters(),
        magnetorquers,
        panels,
        battery,
        _loads(loads or {}),
    )
    smallest = float(np.linalg.eigvalsh(np.asarray(craft.inertia_without_spin))[0])
    if smallest <= 0.0:
        raise FieldError(
            "inertia",
            "the wheels' own inertia exceeds it (J - A Jw A' has the principal moment "
            f"{smallest:.6g} kg m^2, which must be greater than 0); "
            "give the total inertia with wheels, or check the units of the wheel inertia",
        )
    return craft


def _loads(loads: Mapping[str, Any]) -> dict[str, float]:
    checked = {}
    for mode, power in loads.items():
        value = finite_array(mode, power)
        if value.ndim or not value >= 0.0:
            raise FieldError(mode, f"is {brief(power)}; give one number of at least 0, in watts")
        checked[mode] = float(value)
    return checked
