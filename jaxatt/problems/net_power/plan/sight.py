"""Whether the places that tasks look at are in sight."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import epoch, ground
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.motion import Motion
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.reading.directions import as_radians
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_INSTANTS = 61  # of one task


def check_sights(tasks: Sequence[Task], flown: OrbitTask | None, origin: str, least: float) -> None:
    """Refuse a task whose place sinks below the least elevation [rad] at any time.

    flown : the orbit; None without one, or without its epoch.  Raises `ScenarioError`.
    """
    for index, task in enumerate(tasks):
        if task.site is None:
            continue
        place = f"{math.degrees(task.site.latitude):g}, {math.degrees(task.site.longitude):g}"
        where = f'{origin}: [[tasks]] no. {index + 1} "{task.name}" target_deg = [{place}]: '
        if flown is None:
            raise ScenarioError(
                f"{where}nobody knows where the Earth is without an orbit and its epoch; add "
                "[orbit] with epoch, or drop the target"
            )
        times, angles = elevations(task, flown)
        worst = int(np.argmin(angles))
        if angles[worst] >= least:
            continue
        best, days = int(np.argmax(angles)), float(flown.days)
        meant = as_radians(math.degrees(task.site.latitude), math.degrees(task.site.longitude))
        mend = "move the task in time, or check the target and the orbit's epoch"
        raise ScenarioError(
            f"{where}is out of sight: the satellite stands {math.degrees(angles[worst]):.1f} deg "
            f"above its horizon at {clock_text(times[worst], days)} and at most "
            f"{math.degrees(angles[best]):.1f} deg at {clock_text(times[best], days)}, where at "
            f"least {math.degrees(least):g} deg are asked for; "
            + "; ".join(filter(None, (meant, mend)))
        )


def elevations(task: Task, flown: OrbitTask) -> tuple[Floats, Floats]:
    """Times (T,) [s] over a task, and the elevation (T,) [rad] of the satellite at its place."""
    assert task.site is not None
    times = np.linspace(task.start, task.end, _INSTANTS)
    positions = positions_over_ground(flown, times)
    site = task.site
    return times, np.asarray(ground.elevation(positions, site.latitude, site.longitude))


def positions_over_ground(flown: OrbitTask, times: Floats) -> Floats:
    """Positions (T, 3) [m] of the satellite in Earth-fixed axes at times (T,) [s]."""
    return np.asarray(_positions(flown.motion, jnp.asarray(flown.days), jnp.asarray(times)))


@functools.partial(jax.jit, compiler_options=RUNS_ONCE)
def _positions(motion: Motion, days: jax.Array, times: jax.Array) -> jax.Array:
    r_i = motion.at(times).position
    return ground.earth_fixed(r_i, days + times / epoch.SECONDS_PER_DAY)
