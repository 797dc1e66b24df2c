"""A scenario as checked data, in SI units and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from jaxatt.environment.ephemeris import Ephemeris
from jaxatt.environment.orbit_data.path import OrbitPath
from jaxatt.problems.manoeuvre import InitialState, Target, Waypoint
from jaxatt.problems.pointing.case import FREE, Pointing
from jaxatt.problems.scenario_parts import BODY_TORQUE, UNDISTURBED, USUAL
from jaxatt.problems.scenario_parts import Control as Control
from jaxatt.problems.scenario_parts import Disturbances as Disturbances
from jaxatt.problems.scenario_parts import Horizon as Horizon
from jaxatt.problems.scenario_parts import Objective as Objective
from jaxatt.problems.scenario_parts import SolverSettings as SolverSettings
from jaxatt.problems.scenario_parts import Transcription as Transcription
from jaxatt.problems.scenario_parts import Window as Window
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import Spacecraft


@dataclass(frozen=True)
class Orbit:
    """Osculating Keplerian elements at the start: [m], [1], four times [rad], [m^3/s^2].

    days : the start, days since J2000; None where nothing asks for the date.
    path : what the host knows of an orbit that is no ellipse: a file's or a perturbed one.
    motion : that orbit, sampled for as long as the scenario takes.
    """

    semi_major_axis: float
    eccentricity: float
    inclination: float
    raan: float
    argument_of_periapsis: float
    true_anomaly: float
    gravitational_parameter: float
    days: float | None = None
    path: OrbitPath | None = field(default=None, compare=False, repr=False)
    motion: Ephemeris | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, eq=False)
class Scenario:
    """One manoeuvre to optimise.

    Attributes
    ----------
    name, title, source : str
    system : "spacecraft", or the name of a toy
    family : name of the family of problems that it belongs to, see `jaxatt.problems.registry`
    vehicle, orbit
        None for a toy system; without an orbit attitudes are relative to the inertial frame.
    targets : tuple of Target
        One, or one a phase for successive optimisations, each over the whole horizon.
    printed : mapping
        The values that the source prints, as in the file.
    notes : tuple of str
        What was changed while reading, e.g. a quaternion that was normalised.
    transcription : Transcription
        Of time-optimal turns only.
    options
        What a family from outside the package reads beyond these.
    pointing
        Cones to keep out of or within, and limits on the body's rate.
    document, origin, folder
        The TOML document, where it came from and its folder, so that `replace` can read it again.
    """

    name: str
    title: str
    source: str
    system: str
    family: str
    initial: InitialState
    targets: tuple[Target, ...]
    horizon: Horizon
    objective: Objective
    solver: SolverSettings
    vehicle: Spacecraft | None = None
    orbit: Orbit | None = None
    waypoint: Waypoint | None = None
    disturbances: Disturbances = UNDISTURBED
    control: Control = BODY_TORQUE
    windows: tuple[Window, ...] = ()
    transcription: Transcription = USUAL
    pointing: Pointing = FREE
    options: Any = None
    printed: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    document: Mapping[str, Any] = field(default_factory=dict, repr=False)
    origin: str = field(default="scenario", repr=False)
    folder: Path | None = field(default=None, repr=False)

    @property
    def leaves_roll_free(self) -> bool:
        """Whether a target asks for the direction of one body axis only."""
        return any(target.boresight is not None for target in self.targets)

    def aiming_at(self, q_ob: Floats) -> Scenario:
        """The same manoeuvre to another target attitude (4,); what else it asks for stays."""
        return replace(self, targets=(replace(self.targets[0], q_ob=q_ob),))
