"""Checks of numbers on the host, before anything is traced."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


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


def finite_array(field: str, value: Any, *, infinite: bool = False) -> Float64:
    """Return `value` as float64, or raise `FieldError` if it holds anything but real numbers.

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
        # Among numbers NumPy would silently read true as 1.
        holds_bool = isinstance(value, (list, tuple)) and any(
            isinstance(item, (bool, np.bool_)) for item in np.asarray(value, dtype=object).flat
        )
        if raw.dtype.kind not in "iuf" or holds_bool:
            raise TypeError
        array = raw.astype(np.float64)
    except (TypeError, ValueError):
        raise FieldError(
            field,
            f"{value!r} is not an array of real numbers; give numbers in rows of equal length",
        ) from None
    allowed = ~np.isnan(array) if infinite else np.isfinite(array)
    if not allowed.all():
        bad = array[~allowed].flat[0]
        raise FieldError(field, f"holds {bad}, which is not a finite number; give finite numbers")
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
    allowed = array >= 0.0 if zero else array > 0.0
    if not allowed.all():
        bad = array[~allowed][0]
        least = "at least 0" if zero else "greater than 0"
        raise FieldError(field, f"holds {bad:g}; every value must be {least}")
    return array
