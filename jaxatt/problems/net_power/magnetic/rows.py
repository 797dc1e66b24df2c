"""Points of the Runge-Kutta formula, and rows of derivatives at them, in lanes.

Coordinates and rows are tuples of arrays with lanes behind their own axes
(`jaxatt.optimize.lanes`): to put them together at every point takes longer than to compute them.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.attitude.components import Scalar
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.momentum_model import Components

MOVING, WIDTH = 6, 10
"""Coordinates that move; directions: turn, rate, log of the time, dipole."""


class Point(NamedTuple):
    """Row of the formula: whether a step begins, shares of the rate before and of its own, its
    instant."""

    begins: Array | Flags
    before: Array | Floats
    own: Array | Floats
    instant: Array | npt.NDArray[np.int64]


def points(steps: int) -> Point:
    """All points of so many steps; every field has the axis (P,)."""
    h = 1.0 / steps
    return Point(
        np.tile([True, False, False, False], steps),
        np.tile([0.0, 0.5, 0.5, 1.0], steps) * h,
        np.tile([1.0, 2.0, 2.0, 1.0], steps) * h / 6.0,
        np.add.outer(2 * np.arange(steps), [0, 1, 1, 2]).ravel(),
    )


def chosen(which: Array | Flags, new: Components, old: Components) -> Components:
    """New parts where `which` () holds, or else the old ones."""
    return tuple(jnp.where(which, a, b) for a, b in zip(new, old, strict=True))


def ahead(base: Components, length: Array | float, rate: Components) -> Components:
    """Sum of parts and a length times their rates; the length has their number of axes."""
    return tuple(b + length * r for b, r in zip(base, rate, strict=True))


def scaled_by(factor: float, parts: Components) -> Components:
    """Product of a number and all parts."""
    return tuple(factor * part for part in parts)


def times_row(factor: Scalar, row: Array | int) -> Array:
    """Product of an array () with lanes and a row (10,) with lanes."""
    return jnp.asarray(factor)[None] * row


def unit_rows(like: Array) -> list[Array]:
    """Rows (10,) of the unit matrix, with the lanes of an array () with lanes."""
    rows = jnp.eye(WIDTH, dtype=like.dtype)[..., None] + like[None, None]
    return [rows[k] for k in range(WIDTH)]
