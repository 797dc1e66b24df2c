"""Read the scenario of a sparse manoeuvre of a spacecraft from a TOML document."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.hands_off.reading.parts import read_parts
from jaxatt.problems.manoeuvre import Target, Waypoint
from jaxatt.problems.pointing.case import Pointing
from jaxatt.problems.reading import manoeuvre
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.moments import moments_of
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.pointing import check_moments, read_pointing
from jaxatt.problems.scenario import (
    Horizon,
    Orbit,
    Scenario,
)
from jaxatt.spacecraft import Spacecraft


def read_hands_off(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    notes: list[str] = []
    parts = read_parts(document, origin, folder, notes, faults)
    vehicle, horizon = parts.vehicle, parts.horizon
    orbit = faults.of(_read_orbit, document, origin, folder, notes)
    orbit = faults.of(_covering, document, origin, orbit, horizon)
    sky = faults.of(sky_over, orbit, folder)
    targets = faults.of(
        manoeuvre.read_targets, document, origin, notes, sky, horizon, vehicle.wheels
    )
    faults.of(_check_bias, origin, vehicle, targets)
    waypoint = faults.of(_read_waypoint, document, origin, horizon, notes, sky)
    pointing = faults.of(_read_pointing, document, origin, notes, sky, horizon)
    speeds = faults.or_else(parts.speeds, np.zeros(0))
    initial = faults.of(
        manoeuvre.read_initial, faults.table(document, "initial"), origin, notes, sky, speeds
    )
    faults.refuse()
    scenario = Scenario(
        **vars(parts.heading),
        family="hands-off",
        vehicle=vehicle,
        orbit=orbit,
        initial=initial,
        targets=targets,
        waypoint=waypoint,
        horizon=horizon,
        disturbances=parts.disturbances,
        control=parts.control,
        objective=parts.objective,
        windows=parts.windows,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
        pointing=pointing,
    )
    if scenario.pointing:
        check_moments(scenario.pointing, moments_of(scenario), origin)
    return scenario


def _read_orbit(
    document: dict[str, Any],
    origin: str,
    folder: Path | None,
    notes: list[str],
) -> Orbit | None:
    if "orbit" not in document:
        return None
    return read_orbit(document["orbit"], origin, folder, notes)


def _covering(
    document: dict[str, Any], origin: str, orbit: Orbit | None, horizon: Horizon
) -> Orbit | None:
    if orbit is None:
        return None
    return covering(orbit, document["orbit"], origin, _length(horizon, _phases(document)))


def _check_bias(origin: str, vehicle: Spacecraft, targets: tuple[Target, ...]) -> None:
    if vehicle.thrusters.count and any(target.wheel_bias is not None for target in targets):
        raise ScenarioError(
            f"{origin}: [target] wheel_bias_rad_s: not beside thrusters; drop it, or drop "
            "[vehicle.thrusters]"
        )


def _read_waypoint(
    document: dict[str, Any], origin: str, horizon: Horizon, notes: list[str], sky: Sky
) -> Waypoint | None:
    if "waypoint" not in document:
        return None
    if "legs" in document:
        raise ScenarioError(f"{origin}: [waypoint] and [[legs]] are both given; keep one")
    return manoeuvre.read_waypoint(document["waypoint"], origin, horizon, notes, sky)


def _read_pointing(
    document: dict[str, Any], origin: str, notes: list[str], sky: Sky, horizon: Horizon
) -> Pointing:
    phases = _phases(document)
    first = (horizon.shortest if horizon.free else horizon.duration) * phases
    return read_pointing(document, origin, notes, sky, first, _length(horizon, phases))


def _phases(document: dict[str, Any]) -> int:
    """Number of phases, before their targets are read."""
    legs = document.get("legs")
    return len(legs) if isinstance(legs, list) else 1


def _length(horizon: Horizon, phases: int) -> float:
    """Longest time [s] that all phases take, with the flight after the end."""
    longest = horizon.longest if horizon.free else horizon.duration
    return longest * (phases + horizon.coast_intervals / horizon.intervals)
