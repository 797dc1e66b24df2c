"""Fronts between two quantities of a scenario: what is asked of a family, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True)
class Quantity:
    """A quantity in tables, files and figures.

    name : in words.  key : in files, with its unit.  unit : in words.
    logarithmic : whether its values span decades.
    """

    name: str
    key: str
    unit: str
    logarithmic: bool = False

    @property
    def label(self) -> str:
        """Name with unit."""
        return f"{self.name} [{self.unit}]"


@dataclass(frozen=True, eq=False)
class FrontRequest:
    """What a front is asked for.

    over : "time" or "error", what the gain is weighed against.
    points : number of points (K,).  values : (K,) of what the family varies, positive and rising;
    None where the family is to choose.
    """

    over: str
    points: int
    values: Floats | None = None


@dataclass(frozen=True, eq=False)
class Reference:
    """Another way of flying, beside a front: costs (M,) and gains (M,) in its units."""

    name: str
    costs: Floats
    gains: Floats


@dataclass(frozen=True, eq=False)
class Front:
    """Best answers for K values of what was varied, which were solved together.

    varied : with values (K,).  cost : wanted small, costs (K,).  gain : wanted large, gains (K,).
    Costs and gains are those of the fine flights.  phases : (K,) records of these.
    passed_on : (K,), whether the answer was found from one of a neighbouring point.
    reference : None without one.
    """

    varied: Quantity
    values: Floats
    cost: Quantity
    costs: Floats
    gain: Quantity
    gains: Floats
    phases: tuple[Phase, ...]
    passed_on: Flags
    reference: Reference | None = None

    @property
    def reached(self) -> Flags:
        """Whether the flight of each point meets what was asked of all of them, (K,)."""
        return np.array([phase.reached for phase in self.phases])

    @property
    def best(self) -> Flags:
        """Points on the front, (K,): those that reached and that no other such point dominates."""
        return self.reached & ~dominated(self.costs, self.gains, self.reached)


def dominated(costs: Floats, gains: Floats, among: Flags) -> Flags:
    """Whether some point of `among` has no more cost and no less gain, and is not as good, (K,).

    costs, gains : (K,).
    """
    cheaper = costs[None] <= costs[:, None]
    richer = gains[None] >= gains[:, None]
    other = (costs[None] < costs[:, None]) | (gains[None] > gains[:, None])
    return np.asarray((cheaper & richer & other & among[None]).any(axis=1))
