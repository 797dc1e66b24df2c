"""Magnetorquers: coils or rods that make a magnetic dipole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import SMALLEST, FieldError, Float64, brief, finite_array, positive
from jaxatt.spacecraft.parts.array import Array


@dataclass(frozen=True, eq=False)
class Magnetorquers:
    """One magnetorquer on each body axis; build them with `magnetorquers`, which checks the
    numbers.

    Where they act for a share of every period only, as beside a magnetometer that is read in the
    rest, dipoles and powers are means over the period.

    dipole_limit : (3,) [A m^2], largest absolute dipole about each axis, in the mean.
    full_power : () [W], drawn by all three at their limits, in proportion to each dipole; or
    turns : (3,), coil_area : (3,) [m^2] and resistance : (3,) [ohm] of the coils, whose loss goes
    with the square of the dipole.  None where not known.
    duty : share of a period in which they act.
    """

    dipole_limit: Array
    full_power: Array | float | None = None
    turns: Array | None = None
    coil_area: Array | None = None
    resistance: Array | None = None
    duty: Array | float = 1.0

    @property
    def loss_coefficient(self) -> Array:
        """Loss R / (n A)^2 of the coils for a mean dipole of one, (3,) [W/(A m^2)^2]; zero where
        their resistance is not known.

        The dipole while they act is the mean over the duty, and its loss counts for that share.
        """
        if self.turns is None or self.coil_area is None or self.resistance is None:
            return np.zeros(3)
        coefficient: Array = self.resistance / (self.turns * self.coil_area) ** 2 / self.duty
        return coefficient


def magnetorquers(
    dipole_limit: Any,
    full_power: Any = None,
    turns: Any = None,
    coil_area: Any = None,
    resistance: Any = None,
    duty: Any = 1.0,
) -> Magnetorquers:
    """Return checked magnetorquers.

    dipole_limit : float or (3,) [A m^2].  full_power : float [W], of all three at their limits; or
    turns, coil_area [m^2] and resistance [ohm], float or (3,), all three of them; each while they
    act.  duty : share of a period in which they act, at most 1.
    All greater than 0.  Raises `FieldError`, a `ValueError`.
    """
    share = finite_array("duty", duty)
    if share.ndim or not SMALLEST <= share <= 1.0:
        raise FieldError("duty", f"is {brief(duty)}; give one number greater than 0 and at most 1")
    acting = float(share)
    limit = acting * _per_axis("dipole_limit", dipole_limit)
    coil = {"turns": turns, "coil_area": coil_area, "resistance": resistance}
    given = {field: value for field, value in coil.items() if value is not None}
    if given and full_power is not None:
        raise FieldError(
            "full_power",
            "is given beside properties of the coils; keep one of the two models of the power",
        )
    if given and len(given) < len(coil):
        missing = next(field for field in coil if field not in given)
        raise FieldError(
            missing,
            "is missing; the loss of a coil needs its turns, its area and its resistance, so give "
            "all three or none",
        )
    if full_power is not None:
        power = finite_array("full_power", full_power)
        if power.ndim or not power >= SMALLEST:
            raise FieldError(
                "full_power", f"is {brief(full_power)}; give one number greater than 0, in watts"
            )
        return Magnetorquers(limit, acting * float(power), duty=acting)
    coils = {k: _per_axis(k, v) for k, v in given.items()}
    return Magnetorquers(limit, None, **coils, duty=acting)


def _per_axis(field: str, value: Any) -> Float64:
    array = finite_array(field, value)
    if array.shape not in ((), (3,)):
        raise FieldError(
            field,
            f"has shape {array.shape}; give one number for all or three numbers, one a body axis",
        )
    return np.broadcast_to(positive(field, array), (3,)).copy()
