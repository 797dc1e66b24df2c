"""Whether the floor of the battery can hold at all, before anything is solved."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at
from jaxatt.problems.net_power.sun_directions import best_directions
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.battery import charge_along
from jaxatt.spacecraft.panels import SolarPanels, collecting_area

_STEP = 1.0  # [s], of the account
_SLACK = 1e-3
"""Share of the energy that the account may be wrong by."""
_JOULE = 3600.0


def check_floor(
    tasks: Sequence[Task], satellite: Satellite, floor: float, origin: str, days: float | None
) -> None:
    """Refuse a plan whose loads alone drain the battery below its floor [J].

    The account is the best that can be had: harvests face the sun throughout, tasks of prescribed
    attitude are taken as they are, and actuators cost nothing.
    Raises `ScenarioError`, which says in which task, and how much is missing.
    """
    battery = satellite.craft.battery
    if battery is None or not np.isfinite(floor):
        return
    charge = float(battery.charge)
    for index, task in enumerate(tasks):
        times, best = best_charge(task, satellite, charge)
        low = int(np.argmin(best))
        missing = floor - best[low]
        if missing > _SLACK * task.load * task.duration:
            raise ScenarioError(
                f'{origin}: [[tasks]] no. {index + 1} "{task.name}": the battery cannot stay above '
                f"its floor of {floor / _JOULE:.4g} Wh: even with all harvests facing the sun and "
                f"no actuation it holds {best[low] / _JOULE:.4g} Wh at "
                f"{clock_text(times[low], days)}, {missing / _JOULE:.3g} Wh too little; shorten "
                "tasks or lower their loads, harvest longer before, start with more charge, or "
                "lower the floor"
            )
        charge = float(best[-1])


def best_charge(task: Task, satellite: Satellite, charge: float) -> tuple[Floats, Floats]:
    """Times (n,) [s] of a task, and the most charge (n,) [J] that the battery can hold then."""
    craft, light = satellite.craft, satellite.light
    assert craft.battery is not None and craft.panels is not None
    times = np.linspace(task.start, task.end, max(2, round(task.duration / _STEP) + 1))
    sun, share = sunlight_at(satellite, times)
    area = _area(task, craft.panels, times, sun)
    power = np.asarray(craft.battery.net(float(light.irradiance) * share * area, task.load))
    changes = 0.5 * (times[1] - times[0]) * (power[1:] + power[:-1])
    return times, np.asarray(charge_along(changes, charge, craft.battery.capacity))


def _area(task: Task, panels: SolarPanels, times: Floats, sun: Floats) -> Floats:
    """Largest collecting area (n,) [m^2] that a task allows."""
    if task.pose is None:
        return np.full(len(times), best_directions(panels).most)
    q_ib = np.stack([task.pose.after(time - task.start).q_ib for time in times])
    return np.asarray(collecting_area(panels, quaternion.rotate_inverse(q_ib, sun)))
