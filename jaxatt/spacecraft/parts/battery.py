"""A battery with losses on the way in and on the way out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jaxatt.spacecraft.checks import SMALLEST, FieldError, finite_array
from jaxatt.spacecraft.parts.array import Array


@dataclass(frozen=True, eq=False)
class Battery:
    """A battery; build it with `battery`, which checks the numbers.

    capacity : () [J]; inf where it is not known.  charge : () [J], at time zero.
    input_efficiency, output_efficiency : (), shares of the energy that arrive in it and at what it
    feeds.
    """

    capacity: Array | float
    charge: Array | float
    input_efficiency: Array | float = 1.0
    output_efficiency: Array | float = 1.0

    def net(self, gained: Any, drawn: Any) -> Any:
        """What the battery keeps of energies or powers gained and drawn, of one shape.

        All energy passes through the battery; Kristiansen (2023), eqs. (5.3) and (5.5).
        """
        return self.input_efficiency * gained - drawn / self.output_efficiency


def battery(
    capacity: Any = float("inf"),
    charge: Any = None,
    input_efficiency: Any = 1.0,
    output_efficiency: Any = 1.0,
) -> Battery:
    """Return a checked battery.

    capacity : [J], greater than 0.  charge : [J], at most the capacity; full by default.
    input_efficiency, output_efficiency : greater than 0 and at most 1.
    Raises `FieldError`, a `ValueError`.
    """
    most = _number("capacity", capacity, infinite=True)
    if not most >= SMALLEST:
        raise FieldError("capacity", f"is {most:g} J; give a number greater than 0")
    if charge is None and most == float("inf"):
        charge = 0.0
    now = most if charge is None else _number("charge", charge)
    if now < 0.0:
        raise FieldError("charge", f"is {now:g} J; give a number of at least 0")
    if now > most:
        raise FieldError(
            "charge",
            f"starts at {now:g} J, above the capacity of {most:g} J; lower the charge to at most "
            "the capacity, or check the units of both",
        )
    shares = [
        _share("input_efficiency", input_efficiency),
        _share("output_efficiency", output_efficiency),
    ]
    return Battery(most, now, *shares)


def _number(field: str, value: Any, *, infinite: bool = False) -> float:
    array = finite_array(field, value, infinite=infinite)
    if array.ndim:
        raise FieldError(field, f"has shape {array.shape}; give one number")
    return float(array)


def _share(field: str, value: Any) -> float:
    share = _number(field, value)
    if not 0.0 < share <= 1.0:
        raise FieldError(field, f"is {share:g}; give a share greater than 0 and at most 1")
    return share
