"""Speeds that reaction wheels avoid: around zero, where bearings suffer, or at a resonance.

A band is one of magnitudes, so that it stands for both senses of rotation; from 0 rad/s it is a
band around zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, Float64, brief, finite_array, positive_per_item
from jaxatt.spacecraft.parts.array import Array


@dataclass(frozen=True, eq=False)
class SpeedBands:
    """Bands of m speeds that n wheels avoid; build them with `speed_bands`.

    Attributes
    ----------
    slowest, fastest : (m, n) arrays [rad/s]
        Edges of each band, as magnitudes of the speed of each wheel relative to the body.
    longest_stay : (m,) array [s]
        Time within which a wheel must leave the band; 0 where it must never enter.
    """

    slowest: Array
    fastest: Array
    longest_stay: Array

    @property
    def count(self) -> int:
        """Number of bands."""
        return int(self.longest_stay.shape[-1])

    def of_wheels(self, places: Sequence[int]) -> SpeedBands:
        """The same bands, of some of the wheels."""
        low, high = (np.asarray(edge)[:, list(places)] for edge in (self.slowest, self.fastest))
        return SpeedBands(low, high, self.longest_stay)

    @property
    def names(self) -> tuple[str, ...]:
        """Texts of the bands, e.g. "0 to 20", in rad/s."""
        edges = zip(np.asarray(self.slowest), np.asarray(self.fastest), strict=True)
        return tuple(f"{_text(low)} to {_text(high)}" for low, high in edges)

    @property
    def sides(self) -> tuple[Float64, Float64]:
        """Edges a < b of the intervals of signed speed that the bands are, (m, 2, n) [rad/s] each.

        For one sense of rotation and for the other; twice the same for a band around zero.
        """
        low, high = np.asarray(self.slowest), np.asarray(self.fastest)
        around = low == 0.0
        a = np.stack([-high, np.where(around, -high, low)], axis=1)
        b = np.stack([np.where(around, high, -low), high], axis=1)
        return a, b


NO_BANDS = SpeedBands(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0))


def _text(edge: Float64) -> str:
    """Text of one edge: a number, or one for each wheel."""
    lowest, highest = float(np.min(edge)), float(np.max(edge))
    return f"{lowest:g}" if lowest == highest else f"({', '.join(f'{e:g}' for e in edge)})"


def speed_bands(bands: Sequence[tuple[Any, Any, Any]], count: int) -> SpeedBands:
    """Return checked bands of `count` wheels.

    Parameters
    ----------
    bands : sequence of (slowest, fastest, longest stay)
        Edges, each one number or one for each wheel [rad/s], and a time [s], 0 for never entering.

    Raises
    ------
    FieldError
        With "slowest", "fastest" or "longest_stay" as its field.
    """
    if not bands:
        return SpeedBands(np.zeros((0, count)), np.zeros((0, count)), np.zeros(0))
    edges = [_checked(*band, count) for band in bands]
    return SpeedBands(*(np.stack(each) for each in zip(*edges, strict=True)))


def _checked(slowest: Any, fastest: Any, stay: Any, count: int) -> tuple[Float64, Float64, Float64]:
    low = positive_per_item("slowest", slowest, count, zero=True)
    high = positive_per_item("fastest", fastest, count)
    if (low >= high).any():
        raise FieldError(
            "fastest",
            f"is {brief(fastest)}, not faster than the slow edge {brief(slowest)}; give the slower "
            "edge first",
        )
    longest = finite_array("longest_stay", stay)
    if longest.ndim or longest < 0.0:
        raise FieldError("longest_stay", f"is {brief(stay)}; give one time of at least 0 s")
    return low, high, longest
