"""Flat solar panels, one of which may shade the others."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.attitude.smooth_maximum import positive_part
from jaxatt.spacecraft.checks import (
    SMALLEST,
    FieldError,
    Float64,
    finite_array,
    positive_per_item,
)

Array = jax.Array | Float64

INCIDENCE = {"cosine": 1, "cosine-squared": 2}
"""Laws by which a panel's yield falls with the angle between its normal and the sun."""


@jax.tree_util.register_dataclass
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


def collecting_area(panels: SolarPanels, sun_b: Vector | Any, smoothing: Scalar = 0.0) -> jax.Array:
    """Area [m^2] that, times the irradiance, gives the power of the panels.

    The efficiency of the cells is part of it.  Any panel k that shades takes the share
    max(s.n_k, 0) of the yield of every other one.

    sun_b : (..., 3) or `Vector`, unit vector to the sun in body axes.
    smoothing : alpha of the smooth maximum (2.11); 0 is exact.
    Returns (...).  Source: Kristiansen (2023), eqs. (4.4) and (5.4) without the irradiance.
    """
    sun = sun_b if isinstance(sun_b, Vector) else Vector.of(sun_b)
    cosines = [sun.dot(Vector(*panels.normals[:, k])) for k in range(panels.count)]
    lit = [positive_part(cosine, smoothing) for cosine in cosines]
    total: Any = 0.0
    for k in range(panels.count):
        part = lit[k] if panels.incidence_exponent == 1 else lit[k] * cosines[k]
        for other in range(panels.count):
            if other != k:
                part = part * (1.0 - panels.shades[other] * lit[other])
        total = total + panels.efficiency[k] * panels.area[k] * part
    return total


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
