"""Flat solar panels, one of which may shade the others."""

from __future__ import annotations

from typing import Any

import jax

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.attitude.smooth_maximum import positive_part
from jaxatt.spacecraft.parts.panels import INCIDENCE as INCIDENCE
from jaxatt.spacecraft.parts.panels import solar_panels as solar_panels
from jaxatt.spacecraft.pytrees import SolarPanels as SolarPanels


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
