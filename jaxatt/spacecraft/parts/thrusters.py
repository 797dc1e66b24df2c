"""On/off thrusters: valves whose torque has one direction and cannot be reversed."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, Float64, finite_array, positive_per_item
from jaxatt.spacecraft.parts.array import Array

_SENSES = {
    f"{sign}{axis}": (1.0 if sign == "+" else -1.0) * np.eye(3)[i]
    for i, axis in enumerate("xyz")
    for sign in "+-"
}
_REACH_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Thrusters:
    """On/off thrusters; build them with `thrusters`, which checks the numbers.

    Attributes
    ----------
    distribution : (3, m) array
        Body torque of a unit torque of each thruster: B of Kristiansen and Gravdahl (2023), eq. 13.
    torque_limit : (m,) array [N m]
        Torque of each thruster while its valve is open; it is never negative (8d).
    minimum_on_time : (m,) array [s]
        Shortest time for which a valve can open; 0 means no limit.
    minimum_impulse : (m,) array [N m s]
        Smallest angular impulse of one opening; 0 means no limit.
    """

    distribution: Array
    torque_limit: Array
    minimum_on_time: Array
    minimum_impulse: Array

    @property
    def count(self) -> int:
        """Number of thrusters."""
        return int(self.distribution.shape[-1])

    @property
    def shortest_pulse(self) -> Float64:
        """Shortest opening (m,) [s] of each valve that both limits allow."""
        by_impulse = np.asarray(self.minimum_impulse) / np.asarray(self.torque_limit)
        return np.asarray(np.maximum(np.asarray(self.minimum_on_time), by_impulse))

    @property
    def opposed(self) -> tuple[tuple[int, int], ...]:
        """Pairs of thrusters whose torques point in opposite directions."""
        b = np.asarray(self.distribution)
        b = b / np.linalg.norm(b, axis=0, keepdims=True)
        cosine = b.T @ b
        return tuple(
            (i, j)
            for i, j in itertools.combinations(range(self.count), 2)
            if cosine[i, j] < -1.0 + _REACH_TOLERANCE
        )


def no_thrusters() -> Thrusters:
    """Thrusters of a vehicle that has none."""
    empty = np.zeros(0)
    return Thrusters(np.zeros((3, 0)), empty, empty, empty)


def thrusters(
    torque_directions: Any,
    torque_limit: Any,
    minimum_on_time: Any = 0.0,
    minimum_impulse: Any = 0.0,
) -> Thrusters:
    """Return checked thrusters.

    Parameters
    ----------
    torque_directions : (3, m) array_like
        One column a thruster, in body components; its length multiplies the torque.
    torque_limit : float or (m,) array_like [N m]
    minimum_on_time : float or (m,) array_like [s]
    minimum_impulse : float or (m,) array_like [N m s]

    Raises
    ------
    FieldError
        A `ValueError` that names the field, the value and what is allowed.
    """
    matrix = finite_array("torque_directions", torque_directions)
    if matrix.ndim != 2 or matrix.shape[0] != 3 or matrix.shape[1] == 0:
        raise FieldError(
            "torque_directions",
            f"has shape {matrix.shape}, expected (3, m): three body components for each of m "
            "thrusters",
        )
    for index, length in enumerate(np.linalg.norm(matrix, axis=0)):
        if length < 1e-12:
            raise FieldError(
                "torque_directions",
                f"thruster {index + 1} has the torque direction (0, 0, 0); give the direction in "
                "which it turns the body",
            )
    count, what = matrix.shape[1], "thrusters"
    return Thrusters(
        matrix,
        positive_per_item("torque_limit", torque_limit, count, what=what),
        positive_per_item("minimum_on_time", minimum_on_time, count, zero=True, what=what),
        positive_per_item("minimum_impulse", minimum_impulse, count, zero=True, what=what),
    )


def missing_senses(torques: Float64) -> tuple[str, ...]:
    """Body axes and signs about which the thrusters cannot turn the body, e.g. ("-z",).

    torques : (3, k), what the actuators give, one column each.  None is missing exactly if every
    torque can be composed: a sense can if it is a non-negative combination of at most three
    columns (Caratheodory).
    """
    columns = torques / np.linalg.norm(torques, axis=0, keepdims=True)
    return tuple(name for name, sense in _SENSES.items() if not _composed(columns, sense))


def _composed(columns: Float64, wanted: Float64) -> bool:
    for size in (1, 2, 3):
        for chosen in itertools.combinations(range(columns.shape[1]), size):
            part = columns[:, chosen]
            shares, *_ = np.linalg.lstsq(part, wanted, rcond=None)
            exact = np.abs(part @ shares - wanted).max() < _REACH_TOLERANCE
            if exact and shares.min() >= -_REACH_TOLERANCE:
                return True
    return False
