"""Check that a matrix is the inertia of a body."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, Float64, finite_array

_SYMMETRY_TOLERANCE = 1e-9
_TRIANGLE_TOLERANCE = 1e-9
_LARGEST_ROUNDING = 0.01
"""Of the largest moment; numbers rounded more coarsely are no data."""


def checked_inertia(value: Any, notes: list[str]) -> Float64:
    """Return an inertia matrix (3, 3) [kg m^2], symmetric and such as a body can have.

    notes : receives a line where the triangle inequality holds within the rounding of the numbers.
    Raises `FieldError`.
    """
    matrix = finite_array("inertia", value)
    if matrix.shape != (3, 3):
        raise FieldError("inertia", f"has shape {matrix.shape}; give three rows of three numbers")
    skew = np.abs(matrix - matrix.T)
    if skew.max() > _SYMMETRY_TOLERANCE * np.abs(matrix).max():
        i, j = (int(k) for k in np.unravel_index(int(skew.argmax()), (3, 3)))
        raise FieldError(
            "inertia",
            f"is not symmetric: row {i + 1}, column {j + 1} holds {matrix[i, j]:g}, but row {j + 1}"
            f", column {i + 1} holds {matrix[j, i]:g}; both must be the same number",
        )
    symmetric: Float64 = 0.5 * (matrix + matrix.T)
    moments = np.linalg.eigvalsh(symmetric)
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] <= 0.0:
        raise FieldError(
            "inertia",
            f"is not positive definite: its principal moments are {shown} kg m^2; all must be "
            "greater than 0 (check the signs of the products of inertia)",
        )
    excess = moments[2] - moments[0] - moments[1]
    if excess > _TRIANGLE_TOLERANCE * moments[2]:
        if excess > min(_rounding(matrix), _LARGEST_ROUNDING * moments[2]):
            raise FieldError(
                "inertia",
                f"breaks the triangle inequality: of its principal moments {shown} kg m^2 the "
                "largest exceeds the sum of the other two, which no body can have; check the "
                "moments and units",
            )
        notes.append(
            f"of the principal moments of inertia {shown} kg m^2 the largest exceeds the sum of "
            f"the other two by {excess:.2g}, within the rounding of the numbers"
        )
    return symmetric


def _rounding(matrix: Float64) -> float:
    """By how much rounding to the last decimal given can raise the excess of the largest moment.

    Half a unit of the last decimal in every entry moves each moment by at most the sum of a row.
    """
    given = matrix[matrix != 0.0]
    places = [Decimal(repr(float(entry))).normalize().as_tuple().exponent for entry in given]
    unit = 10.0 ** min(int(place) for place in places)
    row = int((matrix != 0.0).sum(axis=1).max())
    return 3.0 * row * 0.5 * unit * (1.0 + _SYMMETRY_TOLERANCE)
