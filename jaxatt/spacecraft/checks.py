"""Checks of numbers on the host, before anything is traced."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]

LARGEST, SMALLEST = 1e30, 1e-30
"""Sizes that a number may have, other than 0: products of several must stay finite, too."""


class FieldError(ValueError):
    """A value that a constructor cannot accept, with the field's name and what is allowed.

    Parameters
    ----------
    field : str
        Name of the offending field, e.g. ``"inertia"``.
    problem : str
        The value, what is allowed and how to mend it.
    """

    def __init__(self, field: str, problem: str) -> None:
        super().__init__(f"{field}: {problem}")
        self.field = field
        self.problem = problem

    @property
    def problem_and_mend(self) -> tuple[str, str]:
        """What is wrong with the value, and how to mend it."""
        problem, _, mend = self.problem.partition("; ")
        return problem, mend


def as_float(value: Any) -> float:
    """Return a number as float, infinite where it is larger than any; `TypeError` for others."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.number)):
        raise TypeError
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def brief(value: Any) -> str:
    """Return a text of a value that fits into a message."""
    try:
        text = repr(value)
    except ValueError:  # whole numbers of thousands of digits
        text = f"a number of about {value.bit_length() * 3 // 10} digits"
    return text if len(text) <= 80 else f"{text[:77]}..."


def finite_array(field: str, value: Any, *, infinite: bool = False) -> Float64:
    """Return `value` as float64, or raise `FieldError` if it holds anything but real numbers.

    Numbers beyond `LARGEST` are refused, too.

    Parameters
    ----------
    field : str
        Name used in the message.
    value : array_like
        Numbers of any shape.
    infinite : bool
        Whether ``inf`` is allowed; NaN never is.
    """
    try:
        raw = np.asarray(value)
        if raw.dtype.kind == "O":  # as NumPy keeps whole numbers of more than 64 bits
            raw = np.asarray([as_float(item) for item in raw.flat]).reshape(raw.shape)
        # Among numbers NumPy would silently read true as 1.
        holds_bool = isinstance(value, (list, tuple)) and any(
            isinstance(item, (bool, np.bool_)) for item in np.asarray(value, dtype=object).flat
        )
        if raw.dtype.kind not in "iuf" or holds_bool:
            raise TypeError
        array = raw.astype(np.float64)
    except (TypeError, ValueError):
        if isinstance(value, str):
            raise FieldError(field, "is a text; write numbers without quotes") from None
        raise FieldError(
            field,
            f"{brief(value)} is not an array of real numbers; give numbers in rows of equal length",
        ) from None
    allowed = ~np.isnan(array) if infinite else np.isfinite(array)
    if not allowed.all():
        bad = array[~allowed].flat[0]
        raise FieldError(field, f"holds {bad}, which is not a finite number; give finite numbers")
    large = np.isfinite(array) & (np.abs(array) > LARGEST)
    if large.any():
        raise FieldError(
            field,
            f"holds {array[large].flat[0]:g}; numbers beyond {LARGEST:g} cannot be computed with; "
            "check the units",
        )
    return array


def positive_per_item(
    field: str,
    value: Any,
    count: int,
    *,
    infinite: bool = False,
    zero: bool = False,
    what: str = "wheels",
) -> Float64:
    """Return a positive number for each of `count` items; one number stands for all of them.

    infinite, zero : whether ``inf`` and 0 are allowed.  what : the items, for messages.
    """
    array = finite_array(field, value, infinite=infinite)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise FieldError(
            field,
            f"has shape {array.shape}, but there are {count} {what}; "
            f"give one number for all or {count} numbers",
        )
    return positive(field, array, zero=zero)


def positive(field: str, array: Float64, *, zero: bool = False) -> Float64:
    """Return an array of numbers that are greater than 0, or 0 where `zero` allows it."""
    allowed = (array >= SMALLEST) | (zero & (array == 0.0))
    if not allowed.all():
        bad = array[~allowed].flat[0]
        least = "at least 0" if zero else "greater than 0"
        if bad > 0.0:
            least = f"at least {SMALLEST:g}, below which nothing can be computed"
        raise FieldError(field, f"holds {bad:g}; every value must be {least}")
    return array
