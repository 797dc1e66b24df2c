"""Searches that keep the wheels within their speeds, and their motors within their torque.

Limits that do not bind cost nothing: only where the best answer breaks them in flight are they
taken into the programme, and stricter where it breaks them between the nodes.  Bands that may be
crossed are barred where no answer crosses in time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.net_power.flight import fly
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, WheelLimits
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import overstay, speed_excess
from jaxatt.spacecraft.wheels import ReactionWheels

Search = Callable[[Sequence[Manoeuvre]], Sequence[Solved]]
MOST_SEARCHES = 4
"""With limits, each stricter than the one before."""
_TIGHTER = 1.2


def within_limits(manoeuvres: Sequence[Manoeuvre], search: Search) -> tuple[Solved, ...]:
    """Search manoeuvres of one satellite, and again those whose best answer breaks a limit.

    search : manoeuvres, some of those given or with other limits -> answers to each.
    """
    found = list(search(manoeuvres))
    if not may_bind(manoeuvres[0].satellite.craft.wheels):
        return tuple(found)
    asked, kept = list(enumerate(manoeuvres)), dict(enumerate(found))
    for attempt in range(MOST_SEARCHES + 1):
        broken = []
        for k, manoeuvre in asked:
            limits, reached = stricter(manoeuvre, found[k])
            if reached or limits is None:
                kept[k] = found[k]
            if limits is not None:
                broken.append((k, replace(manoeuvre, limits=limits)))
        if not broken or attempt == MOST_SEARCHES:
            break
        asked = broken
        again = search([manoeuvre for _, manoeuvre in asked])
        for (k, _), solved in zip(asked, again, strict=True):
            found[k] = solved
    return tuple(kept[k] for k in range(len(found)))


def may_bind(wheels: ReactionWheels) -> bool:
    """Whether there are limits that the programme does not have from the beginning."""
    return wheels.has_speed_limits or not wheels.motors.ideal


def keeping_to(manoeuvre: Manoeuvre, limits: WheelLimits | None = None) -> Manoeuvre:
    """The manoeuvre with limits for its search; by default those of the wheels as they are."""
    nothing = np.zeros(manoeuvre.satellite.craft.wheels.count)
    return replace(manoeuvre, limits=limits or WheelLimits(nothing, nothing))


def stricter(manoeuvre: Manoeuvre, solved: Solved) -> tuple[WheelLimits | None, bool]:
    """Limits to search with again, None where the best answer keeps to them; whether any start
    reached."""
    wheels = manoeuvre.satellite.craft.wheels
    flight = fly(manoeuvre, solved.torque, solved.dipole)
    verdict = judge_flight(manoeuvre, flight, solved.dipole is not None)
    content = np.isin(solved.status, (Status.CONVERGED, Status.FEASIBLE))
    reached = bool(verdict.reached.any())
    if not content.any():
        return None, reached
    pool = content & verdict.arrives if (content & verdict.arrives).any() else content
    best = np.array([np.argmax(np.where(pool, solved.claimed, -np.inf))])
    limits = keeping_to(manoeuvre, manoeuvre.limits).limits
    assert limits is not None
    over = speed_excess(wheels, flight.speeds_passed[best], limits.every_band)[0]
    strained = motor_excess(wheels, flight.wheel_torque[best], flight.omega_bw[best])[0]
    late = bool(overstay(wheels, flight.omega_bw[best], flight.step[best])[0] > 0.0)
    fits = max(over.max(), strained.max()) <= Verdict.MARGIN_TOLERANCE
    if fits and (not late or limits.every_band or reached):
        return None, reached
    if manoeuvre.limits is None:
        return replace(limits, every_band=late), reached
    return WheelLimits(
        limits.slower + _TIGHTER * np.maximum(over, 0.0),
        limits.weaker + _TIGHTER * np.maximum(strained, 0.0),
        limits.every_band or late,
    ), reached
