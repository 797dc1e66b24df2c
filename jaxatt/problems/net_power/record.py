"""Record of the energy of one phase, and of how all starts ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from jaxatt.environment.eclipse_times import Eclipse
from jaxatt.records.phase import Phase, Section
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True)
class Energy:
    """Energies [J] of one phase by its flight, with exact panels, absolute values and shadow.

    solar : into the battery.  actuation : of wheels and magnetorquers.  loads : of all other
    subsystems.  baseline : net energy of the PD law in the same time; None without one.
    final_charge, least_charge : of the battery; None without one.
    """

    solar: float
    actuation: float
    loads: float
    baseline: float | None = None
    final_charge: float | None = None
    least_charge: float | None = None

    @property
    def net(self) -> float:
        """Energy that is left [J]."""
        return self.solar - self.actuation - self.loads

    @property
    def gain(self) -> float | None:
        """Net energy above the baseline's [J]."""
        return None if self.baseline is None else self.net - self.baseline

    @staticmethod
    def together(parts: Sequence[Energy]) -> Energy:
        """Energy of several phases, one after the other."""
        first = [part.baseline for part in parts]
        charges = [part.final_charge for part in parts]
        least = [part.least_charge for part in parts if part.least_charge is not None]
        known = [value for value in first if value is not None]
        return Energy(
            solar=sum(part.solar for part in parts),
            actuation=sum(part.actuation for part in parts),
            loads=sum(part.loads for part in parts),
            baseline=sum(known) if len(known) == len(parts) else None,
            final_charge=charges[-1],
            least_charge=min(least) if least else None,
        )


@dataclass(frozen=True, eq=False)
class NetPower(Section):
    """What only the answers of net power have.

    energy : of the phase.  claimed : [J], net energy by the solver's own count.
    start_energy : (S,) [J], net energy of every start's flight; NaN where it is unknown.
    start_score : (S,), what starts are ranked by, the most first: that energy, or the cost [J], or
    [W] for mean power, with its sign changed.  cost : of the answer; None where it is the energy.
    share : of the starts, those that reached and are at the best.  minima : different ones.
    refined : starts whose answer was solved on the manoeuvre's own intervals; those of a long one
    but for the best few are answers on longer intervals.
    violation, stationarity : of the solver at the answer.
    shadow : passages through the Earth's shadow, in times since the epoch.
    baseline : name -> series of the PD law's flight, as the phase's own.
    baseline_errors : name -> error of that flight at its end, as the phase's own.
    task, mode : of a plan; empty for a single manoeuvre.  site : (2,) [deg], latitude and longitude
    of a target on the ground; None without.
    final_time_free : whether it was found with the rest.  by_dipoles : whether dipoles alone are
    decided, and no torques.  saturated : share of the time in which a dipole is at its limit; None
    where there are none.
    """

    @property
    def control_unit(self) -> str:
        """Unit of the decided controls."""
        return "A m^2" if self.by_dipoles else super().control_unit

    energy: Energy
    claimed: float
    start_energy: Floats
    start_score: Floats
    share: float
    minima: int
    refined: int
    violation: float
    stationarity: float
    shadow: tuple[Eclipse, ...]
    baseline: Mapping[str, Floats]
    baseline_errors: Mapping[str, float]
    task: str = ""
    mode: str = ""
    site: Floats | None = None
    final_time_free: bool = False
    cost: float | None = None
    by_dipoles: bool = False
    saturated: float | None = None

    def headline(self, phases: Sequence[Phase]) -> str:
        """Net energy of all phases, and the gain over the baseline."""
        total = energy_of(phases)
        text = f"net energy {total.net:.1f} J"
        if total.gain is not None and total.baseline:
            than = "more" if total.gain >= 0.0 else "less"
            text += f" ({abs(total.gain):.1f} J {than} than the sun-pointing law)"
        return text

    def brief(self, phases: Sequence[Phase]) -> str:
        """Net energy of all phases."""
        return f"{energy_of(phases).net:.6g} J"


def net_power(phase: Phase) -> NetPower:
    """The section of a phase of this family."""
    assert isinstance(phase.section, NetPower)
    return phase.section


def with_starts_of(phase: Phase, old: Phase) -> Phase:
    """The phase with what an earlier search for it tells of all its starts."""
    was = net_power(old)
    section: NetPower = replace(
        net_power(phase),
        start_energy=was.start_energy,
        start_score=was.start_score,
        share=was.share,
        minima=was.minima,
        refined=was.refined,
    )
    return replace(phase, starts=old.starts, section=section)


def energy_of(phases: Sequence[Phase]) -> Energy:
    """Energy of several phases together."""
    return Energy.together([net_power(phase).energy for phase in phases])


def mean_power(energy: Energy, seconds: float) -> float:
    """Mean net power [W]."""
    return energy.net / seconds if seconds > 0.0 else float(np.nan)
