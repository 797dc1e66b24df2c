"""Dates of a year's plans, and how high the sun stands above the orbit on them."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import kepler, sun
from jaxatt.environment.epoch import days_since_j2000, parse
from jaxatt.problems.reading.dates import SUNLIGHT
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Orbit, Scenario
from jaxatt.problems.surroundings import elements_of
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_MOST_DATES = 10_000
_WRITE = (
    "write the first and the last date and, if you like, the days between, such as "
    "2023-01-01:2023-12-31:7"
)


def read_dates(text: str, scenario: Scenario) -> Floats:
    """Epochs (D,), days since J2000, of "first:last" or "first:last:step", at the plan's hour.

    step : in days, 1 by default.  Raises `ScenarioError`.
    """
    parts = text.split(":")
    if len(parts) not in (2, 3):
        raise ScenarioError(f"--dates {text}: {_WRITE}")
    try:
        first, last = (days_since_j2000(parse(each)) for each in parts[:2])
        apart = float(parts[2]) if len(parts) == 3 else 1.0
    except (ValueError, OverflowError):
        raise ScenarioError(f"--dates {text}: {_WRITE}") from None
    if last < first:
        raise ScenarioError(f"--dates {text}: the last date comes before the first; exchange them")
    if not 0.0 < apart < float("inf"):
        raise ScenarioError(f"--dates {text}: {apart:g} days between dates; give more than zero")
    if not (SUNLIGHT.holds(first) and SUNLIGHT.holds(last)):
        raise ScenarioError(
            f"--dates {text}: {SUNLIGHT.name} is known from {SUNLIGHT.span}; give dates within"
        )
    if (last - first) / apart > _MOST_DATES:
        raise ScenarioError(
            f"--dates {text}: more than {_MOST_DATES} dates; give more days between them"
        )
    hour = 0.0
    if scenario.orbit is not None and scenario.orbit.days is not None:
        hour = (scenario.orbit.days + 0.5) % 1.0
    count = int((last - first) / apart + 1e-9) + 1
    return np.asarray(first + hour + apart * np.arange(count, dtype=float), np.float64)


def beta_angle(orbits: Sequence[Orbit | None], days: Floats) -> Floats:
    """Angle (D,) [rad] of the sun above the plane of each orbit; not a number without one."""
    return np.array(
        [
            np.nan
            if orbit is None
            else float(_beta(elements_of(orbit), orbit.gravitational_parameter, day))
            for orbit, day in zip(orbits, days.tolist(), strict=True)
        ]
    )


def _above(elements: kepler.KeplerianElements, mu: float, days: jax.Array) -> jax.Array:
    normal = jnp.cross(*kepler.to_state(elements, mu))
    return jnp.arcsin(sun.sun_direction(days) @ normal / jnp.linalg.norm(normal))


_beta = jax.jit(_above, compiler_options=RUNS_ONCE)
