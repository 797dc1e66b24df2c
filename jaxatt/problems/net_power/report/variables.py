"""Series and variables that net power adds to an archive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jaxatt.problems.net_power.record import net_power
from jaxatt.records.labels import Label, Variable, labelled
from jaxatt.records.phase import Phase

LABELS: Mapping[str, Label] = {
    "q_ib": (("time", "quaternion"), "1", "attitude of the body relative to the inertial frame"),
    "q_ib_reference": (("quaternion",), "1", "target attitude in the inertial frame"),
    "omega_ib_reference": (("axis",), "rad/s", "target rate in the inertial frame"),
    "dipole": (("time", "axis"), "A m^2", "dipole of the magnetorquers in body axes"),
    "light": (("time",), "1", "share of the sunlight that arrives"),
    "solar_power": (("time",), "W", "solar power into the battery"),
    "actuation_power": (("time",), "W", "power of wheels and magnetorquers"),
    "net_power": (("time",), "W", "net power, all loads counted"),
    "net_energy": (("time",), "J", "net energy since the phase's start"),
    "charge": (("time",), "J", "charge of the battery"),
}
"""Axes, unit and words of the family's own series and references."""


def variables(phase: Phase, phases: Sequence[Phase]) -> dict[str, Variable]:
    """Energies of the phase and of every start, and the baseline's flight."""
    found = net_power(phase)
    energy = found.energy
    made = {
        "start_energy": labelled(found.start_energy, ("start",), "J", "net energy, flown again"),
        "net_energy_total": labelled(energy.net, (), "J", "net energy of the phase"),
        "solar_energy": labelled(energy.solar, (), "J", "solar energy into the battery"),
        "actuation_energy": labelled(energy.actuation, (), "J", "of wheels and magnetorquers"),
        "load_energy": labelled(energy.loads, (), "J", "of the other subsystems"),
        "claimed_energy": labelled(found.claimed, (), "J", "net energy by the solver's count"),
        "kkt_violation": labelled(found.violation, (), "1", "largest violation"),
        "kkt_stationarity": labelled(found.stationarity, (), "1", "Lagrangian's gradient"),
        "share_at_best": labelled(found.share, (), "1", "share of starts at the best minimum"),
    }
    for name, values in found.baseline.items():
        if name in LABELS:
            dims, unit, words = LABELS[name]
            made[f"baseline_{name}"] = labelled(values, dims, unit, f"{words}, of the PD law")
    return made
