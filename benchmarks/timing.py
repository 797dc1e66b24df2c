"""Medians, with what is compiled told apart from what runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import jax


@dataclass(frozen=True)
class Timed:
    """first_s : [s] the first call.  run_s : [s] median of later ones.  fastest_s : their least."""

    first_s: float
    run_s: float
    fastest_s: float

    @property
    def compile_s(self) -> float:
        """What the first call took beyond a later one."""
        return max(0.0, self.first_s - self.run_s)


def timed(run: Callable[[int], object], repeats: int) -> Timed:
    """Time run(i): the first call, one to warm up that is not counted, then `repeats`."""

    def once(index: int) -> float:
        began = time.perf_counter()
        jax.block_until_ready(run(index))
        return time.perf_counter() - began

    first = once(0)
    once(1)
    later = [once(index) for index in range(2, 2 + repeats)]
    return Timed(first, statistics.median(later), min(later))
