"""Account of the energy that a satellite gains and spends in a manoeuvre."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.battery import charge_along


@dataclass(frozen=True, eq=False)
class EnergyAccount:
    """Energy at the battery by interval (S, N) [J]; every efficiency is in it.

    solar : gained.  wheels, magnetorquers, loads : spent; the wheels' may be negative where they
    give energy back.  start_charge : (S,) [J].  capacity : [J], inf where it does not matter.
    """

    solar: Floats
    wheels: Floats
    magnetorquers: Floats
    loads: Floats
    start_charge: Floats
    capacity: float

    @property
    def net(self) -> Floats:
        """Gained less spent by interval, (S, N) [J]."""
        return self.solar - self.wheels - self.magnetorquers - self.loads

    @property
    def solar_J(self) -> Floats:
        """Gained from the sun, (S,) [J]."""
        return self.solar.sum(axis=1)

    @property
    def wheels_J(self) -> Floats:
        """Spent on the wheels, (S,) [J]."""
        return self.wheels.sum(axis=1)

    @property
    def magnetorquers_J(self) -> Floats:
        """Spent on the magnetorquers, (S,) [J]."""
        return self.magnetorquers.sum(axis=1)

    @property
    def loads_J(self) -> Floats:
        """Spent on the other subsystems, (S,) [J]."""
        return self.loads.sum(axis=1)

    @property
    def turnover(self) -> float:
        """Largest energy that a flight gained, or spent on actuators, [J]."""
        spent = np.abs(self.wheels_J) + np.abs(self.magnetorquers_J)
        return float(np.nanmax(np.maximum(np.abs(self.solar_J), spent), initial=0.0))

    @property
    def net_J(self) -> Floats:
        """Gained less spent, (S,) [J], as if the battery were never full."""
        return self.net.sum(axis=1)

    @property
    def charge(self) -> Floats:
        """Charge of the battery at the nodes (S, N + 1) [J].

        A full battery takes no more; below zero the charge tells how much is missing.
        """
        return np.asarray(charge_along(self.net, self.start_charge, self.capacity))

    @property
    def least_charge(self) -> Floats:
        """Smallest charge at a node, (S,) [J]."""
        return self.charge.min(axis=1)

    def pick(self, rows: Any) -> EnergyAccount:
        """The accounts of some of the flights."""
        return EnergyAccount(
            self.solar[rows],
            self.wheels[rows],
            self.magnetorquers[rows],
            self.loads[rows],
            self.start_charge[rows],
            self.capacity,
        )
