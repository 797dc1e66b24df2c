"""Weights of the printed cost of net power."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Weights:
    """Weights of the printed cost (3.5): of the attitude's and the rate's error, and of time.

    In joules, J s^2 and J/s where energy is the cost; in watts, W s^2 and W/s where mean power is.
    """

    attitude: float = 0.0
    rate: float = 0.0
    time: float = 0.0
