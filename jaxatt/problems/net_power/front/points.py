"""Records of the points of a front."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jaxatt.problems.front import Quantity
from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.front.neighbours import Point
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.phase import phase_of
from jaxatt.problems.net_power.record import energy_of, with_starts_of
from jaxatt.problems.net_power.sun_directions import best_directions
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Floats

ENERGY = Quantity("net energy", "net_J", "J")


def phases_of(
    points: Sequence[Point], family: str, baselines: Sequence[PoweredFlight | None]
) -> tuple[Phase, ...]:
    """Records of the best answers, each with how the starts of its own point ended."""
    found = []
    for point, baseline in zip(points, baselines, strict=True):
        phase, _ = phase_of(point.best, family, baseline)
        if point.passed_on:
            own, _ = phase_of(point.of_starts, family, baseline)
            phase = with_starts_of(phase, own)
        found.append(phase)
    return tuple(found)


def gains_of(phases: Sequence[Phase]) -> Floats:
    """Net energy of each flight, (K,) [J]."""
    return np.array([energy_of([phase]).net for phase in phases])


def best_power(satellite: Satellite) -> float:
    """Power [W] of the panels in the attitude that is best in full sunlight."""
    panels = satellite.craft.panels
    if panels is None:
        raise ScenarioError("[vehicle.panels]: the vehicle has none, and earns nothing; add some")
    return float(satellite.light.irradiance) * best_directions(panels).most
