"""Flat solar panels, one of which may shade the others."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import (
    SMALLEST,
    FieldError,
    Float64,
    finite_array,
    positive_per_item,
)
from jaxatt.spacecraft.parts.array import Array

INCIDENCE = {"cosine": 1, "cosine-squared": 2}
"""Laws by which a panel's yield falls with the angle between its normal and the sun."""


@dataclass(frozen=True, eq=False)
class SolarPanels:
    """Flat solar panels; build them with `solar_panels`, which checks the numbers.

    normals : (3, n), outward unit normals in body axes, one column a panel.
    area : (n,) [m^2].  efficiency : (n,), of the cells.
    shades : (n,) 0 or 1, 1 for a deployed panel that hides the others where the sun shines on it.
    incidence_exponent : static, 1 for the cosine law, 2 for its square as in (4.4).
    """

    normals: Array
    area: Array
    efficiency: Array
    shades: Array
    incidence_exponent: int = field(default=1, metadata={"static": True})

    @property
    def count(self) -> int:
        """Number of panels."""
        return int(self.normals.shape[-1])


def solar_panels(
    normals: Any,
    area: Any,
    efficiency: Any,
    shades: int | None = None,
    incidence: str = "cosine",
) -> SolarPanels:
    """Return checked solar panels.

    normals : (3, n), outward normals in body axes, one column a panel; scaled to unit length.
    area : (n,) [m^2].  efficiency : float or (n,), greater than 0 and at most 1.
    shades : index of the deployed panel that shades the others, from 0; None without one.
    incidence : "cosine", or "cosine-squared" as printed in (4.4).
    Raises `FieldError`, a `ValueError`.
    """
    unit = _unit_normals(normals)
    count = unit.shape[1]
    share = positive_per_item("efficiency", efficiency, count, what="panels")
    if share.max() > 1.0:
        raise FieldError(
            "efficiency", f"holds {share.max():g}; give the share of the sunlight, at most 1"
        )
    if incidence not in INCIDENCE:
        raise FieldError("incidence", f"is {incidence!r}; allowed: {', '.join(INCIDENCE)}")
    shading = np.zeros(count)
    if shades is not None:
        if not 0 <= shades < count:
            raise FieldError(
                "shades", f"is panel {shades + 1}; there are {count} panels, counted from 1"
            )
        shading[shades] = 1.0
    return SolarPanels(unit, _area(area, count), share, shading, INCIDENCE[incidence])


def _unit_normals(value: Any) -> Float64:
    normals = finite_array("normals", value)
    if normals.ndim != 2 or normals.shape[0] != 3 or normals.shape[1] == 0:
        raise FieldError(
            "normals",
            f"has shape {normals.shape}; give three body components for each of n panels",
        )
    lengths = np.linalg.norm(normals, axis=0)
    if lengths.min() < 1e-12:
        raise FieldError(
            "normals",
            f"panel {int(lengths.argmin()) + 1} has the normal (0, 0, 0); give the direction that "
            "its cells face",
        )
    unit: Float64 = normals / lengths
    return unit


def _area(value: Any, count: int) -> Float64:
    area = finite_array("area", value)
    if area.shape != (count,):
        raise FieldError(
            "area",
            f"has shape {area.shape}, but there are {count} panels; give {count} areas, one a "
            "normal",
        )
    if area.min() < SMALLEST:
        raise FieldError(
            "area",
            f"panel {int(area.argmin()) + 1} has {area.min():g} m^2; every panel must have an "
            "area greater than 0, so leave out faces without cells",
        )
    return area
