"""Whether the places that tasks look at are in sight."""

from __future__ import annotations

import functools
import math

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import epoch, ground, kepler, orbit
from jaxatt.problems.net_power.plan.reading.times import clock_text
from jaxatt.problems.net_power.plan.task import Plan, Task
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_INSTANTS = 61  # of one task


def check_sights(
    plan: Plan, elements: kepler.KeplerianElements, mu: float, days: float, origin: str
) -> None:
    """Refuse a task whose place sinks below the least elevation at any time.

    elements : of the orbit at the epoch.  days : epoch, days since J2000.  Raises `ScenarioError`.
    """
    for index, task in enumerate(plan.tasks):
        if task.site is None:
            continue
        times, angles = elevations(task, elements, mu, days)
        worst = int(np.argmin(angles))
        if angles[worst] >= plan.least_elevation:
            continue
        best = int(np.argmax(angles))
        place = f"{math.degrees(task.site.latitude):g}, {math.degrees(task.site.longitude):g}"
        raise ScenarioError(
            f'{origin}: [[tasks]] no. {index + 1} "{task.name}" target_deg = [{place}]: is out of '
            f"sight: the satellite stands {math.degrees(angles[worst]):.1f} deg above its horizon "
            f"at {clock_text(times[worst], days)} and at most {math.degrees(angles[best]):.1f} deg "
            f"at {clock_text(times[best], days)}, where at least "
            f"{math.degrees(plan.least_elevation):g} deg are asked for; move the task in time, or "
            "check the target and the orbit's epoch"
        )


def elevations(
    task: Task, elements: kepler.KeplerianElements, mu: float, days: float
) -> tuple[Floats, Floats]:
    """Times (T,) [s] over a task, and the elevation (T,) [rad] of the satellite at its place."""
    assert task.site is not None
    times = np.linspace(task.start, task.end, _INSTANTS)
    positions = positions_over_ground(elements, mu, days, times)
    site = task.site
    return times, np.asarray(ground.elevation(positions, site.latitude, site.longitude))


def positions_over_ground(
    elements: kepler.KeplerianElements, mu: float, days: float, times: Floats
) -> Floats:
    """Positions (T, 3) [m] of the satellite in Earth-fixed axes at times (T,) [s]."""
    return np.asarray(_positions(elements, jnp.asarray(mu), jnp.asarray(days), jnp.asarray(times)))


@functools.partial(jax.jit, compiler_options=RUNS_ONCE)
def _positions(
    elements: kepler.KeplerianElements, mu: jax.Array, days: jax.Array, times: jax.Array
) -> jax.Array:
    r_i, _ = orbit.propagate(*kepler.to_state(elements, mu), times, mu)
    return ground.earth_fixed(r_i, days + times / epoch.SECONDS_PER_DAY)
