"""Find the magnetic field's model for the epoch of an orbit."""

from __future__ import annotations

import datetime as dt

from jaxatt.environment import epoch, igrf
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Orbit


def field_of(orbit: Orbit | None, origin: str) -> igrf.MagneticModel:
    """Return the coefficients of the field at the epoch of the orbit.

    Raises `ScenarioError` without an orbit or an epoch, and where the model has no coefficients.
    """
    if orbit is None:
        raise ScenarioError(f"{origin}: [orbit] is missing; magnetic torques need it, so add one")
    if orbit.days is None:
        raise ScenarioError(
            f"{origin}: [orbit] epoch: missing; magnetic torques need the date, add a line such as "
            'epoch = "2026-06-21T12:00:00Z"'
        )
    moment = epoch.J2000 + dt.timedelta(days=orbit.days)
    year = epoch.decimal_year(moment)
    if not igrf.FIRST_YEAR <= year <= igrf.LAST_YEAR:
        raise ScenarioError(
            f'{origin}: [orbit] epoch = "{moment:%Y-%m-%dT%H:%M:%SZ}": is outside the years of the '
            f"field model IGRF-14, {igrf.FIRST_YEAR:.0f} to {igrf.LAST_YEAR:.0f}; give a date "
            "within, or leave the magnetic torques out"
        )
    return igrf.at_year(year)
