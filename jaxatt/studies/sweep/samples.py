"""Samples of several quantities: grids, random numbers, Latin hypercubes, Sobol sequences."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.tables import MOST_SAMPLES

_FAR = 20.0
"""Ratio of greatest to least of listed values from which they are drawn on a logarithmic axis."""


@dataclass(frozen=True, eq=False)
class Range:
    """Values that a quantity takes: those of a list, or from `low` to `high`.

    values : (L,), or None for a range.  count : of the grid's values within a range.
    logarithmic : whether equal ratios, and not differences, are equally far apart.
    whole : whether only whole numbers are taken.
    """

    values: Floats | None
    low: float = 0.0
    high: float = 0.0
    count: int = 0
    logarithmic: bool = False
    whole: bool = False

    @property
    def spacing(self) -> str:
        """Scale on which the values are seen best: "linear" or "logarithmic"."""
        v = self.values
        far = v is not None and v.min() > 0.0 and v.max() >= _FAR * v.min()
        return "logarithmic" if self.logarithmic or far else "linear"

    def at(self, share: Floats) -> Floats:
        """Values at shares of the way, (S,) from 0 to 1."""
        if self.values is not None:
            index = np.minimum((share * len(self.values)).astype(int), len(self.values) - 1)
            return self.values[index]
        if self.whole:
            return np.minimum(np.floor(self.low + share * (self.high - self.low + 1)), self.high)
        return self._between(share)

    def levels(self) -> Floats:
        """Values of a grid, in their order."""
        if self.values is not None:
            return self.values
        found = self._between(np.linspace(0.0, 1.0, self.count))
        found[0], found[-1] = self.low, self.high  # to the last digit
        return np.unique(np.round(found)) if self.whole else found

    def _between(self, share: Floats) -> Floats:
        if self.logarithmic:
            return np.asarray(self.low * (self.high / self.low) ** share, float)
        return np.asarray(self.low + share * (self.high - self.low), float)


def grid(ranges: Sequence[Range]) -> Floats:
    """All combinations, (S, D); the last quantity changes fastest."""
    levels = [each.levels() for each in ranges]
    count = math.prod(len(each) for each in levels)
    if count > MOST_SAMPLES:
        sizes = " x ".join(str(len(each)) for each in levels)
        raise ScenarioError(
            f"a grid of {sizes} has {count} samples; at most {MOST_SAMPLES} are made"
        )
    return np.stack([axis.ravel() for axis in np.meshgrid(*levels, indexing="ij")], axis=1)


def scattered(method: str, ranges: Sequence[Range], count: int, seed: int) -> Floats:
    """Samples (S, D) of a method other than a grid.

    Sample i of "random" and "sobol" depends on the seed and i only; a Latin hypercube has one
    sample in each of S slices of every quantity.
    """
    share = _shares(method, len(ranges), count, seed)
    return np.stack([each.at(share[:, d]) for d, each in enumerate(ranges)], axis=1)


def _shares(method: str, dimension: int, count: int, seed: int) -> Floats:
    if method == "random":
        return np.random.default_rng(seed).random((count, dimension))
    from scipy.stats import qmc

    if method == "latin-hypercube":
        return np.asarray(qmc.LatinHypercube(dimension, rng=seed).random(count))
    with warnings.catch_warnings():
        # Said in the study's notes.
        warnings.filterwarnings("ignore", "The balance properties", UserWarning)
        return np.asarray(qmc.Sobol(dimension, rng=seed).random(count))


def notes(method: str, count: int) -> tuple[str, ...]:
    """Remarks on a number of samples."""
    if method != "sobol" or count & (count - 1) == 0:
        return ()
    lower = 1 << (count.bit_length() - 1)
    return (
        f"samples = {count}: a Sobol sequence is balanced at powers of two only; {lower} or "
        f"{2 * lower} samples cover the ranges more evenly",
    )
