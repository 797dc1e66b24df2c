"""What a PD law earns that holds the sun attitude and turns to the target before the end."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.problems.net_power.flight import PoweredFlight, fly_steered
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at
from jaxatt.problems.net_power.sun_attitude import sun_attitude
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.steering import Aim, HeldPD


@dataclass(frozen=True)
class PDBaseline:
    """PD law of a baseline, eq. (3.6).

    proportional : K_p [N m].  derivative : K_d [N m s].
    hold : [s], time for which a torque is held; None for the intervals of the manoeuvre.
    turn_back : [s] before the end, when it lets go of the sun.
    nearest_to : "start" or "end", the reference attitude of (3.9), which decides the roll about the
    line to the sun.  path_weight : k_1 [W^2] of (3.8).
    Source: Kristiansen (2023), section 3.2.1.
    """

    proportional: float
    derivative: float
    hold: float | None = None
    turn_back: float = 20.0
    nearest_to: str = "start"
    path_weight: float = 1.0


CHAPTER_4 = PDBaseline(8e-2, 1.08e-1)
"""Gains of Kristiansen (2023), section 4.5."""

CHAPTER_5 = PDBaseline(1e-2, 3.56e-2)
"""Gains of Kristiansen (2023), section 5.7."""


def fly_baseline(
    manoeuvres: Sequence[Manoeuvre], law: PDBaseline, steps: int | None = None
) -> PoweredFlight:
    """Fly the baseline of several manoeuvres of one satellite and one number of intervals.

    steps : Runge-Kutta steps of each torque that is held.
    """
    held = [_resampled(manoeuvre, law.hold) for manoeuvre in manoeuvres]
    craft = held[0].satellite.craft
    steering = HeldPD(
        law.proportional,
        law.derivative,
        np.asarray(craft.wheels.allocation),
        np.asarray(craft.wheels.torque_limit),
    )
    aims = [_aims(manoeuvre, law) for manoeuvre in held]
    q_ib, rate = (np.stack(parts) for parts in zip(*aims, strict=True))
    rows = Aim(Quaternion.of(q_ib), Vector.of(rate))
    return fly_steered(held, np.arange(len(held)), steering, rows, steps=steps)


def _resampled(manoeuvre: Manoeuvre, hold: float | None) -> Manoeuvre:
    if hold is None:
        return manoeuvre
    return dataclasses.replace(manoeuvre, intervals=max(1, round(manoeuvre.duration / hold)))


def _aims(manoeuvre: Manoeuvre, law: PDBaseline) -> tuple[Floats, Floats]:
    """Attitude (N, 4) and rate (N, 3) [rad/s] that the law turns to in each interval."""
    satellite, end, count = manoeuvre.satellite, manoeuvre.end, manoeuvre.intervals
    times: Floats = manoeuvre.start_time + manoeuvre.step * np.arange(float(count))
    reference = manoeuvre.start.q_ib
    if law.nearest_to == "end" and end is not None:
        reference = end.q_ib
    if satellite.craft.panels is None:
        raise ValueError("panels: the vehicle has none, so no attitude earns more than another")
    sun, _ = sunlight_at(satellite, times[:1])
    irradiance = float(satellite.light.irradiance)
    toward = sun_attitude(satellite.craft.panels, irradiance, sun[0], reference, law.path_weight)
    q_ib = np.tile(toward, (count, 1))
    rate = np.zeros((count, 3))
    if end is not None:
        # A node at the moment of turning back counts as after it, whatever rounding says.
        left = manoeuvre.duration - manoeuvre.step * np.arange(float(count))
        back = left <= law.turn_back + 1e-6 * manoeuvre.step
        q_ib[back], rate[back] = end.q_ib, end.omega_ib
    return q_ib, rate
