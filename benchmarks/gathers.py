"""What the processes of one command exchange: how often, how many bytes, and how long it takes.

    python -m benchmarks.gathers solve hypso1-90-45-15 --coordinator HOST:PORT --processes 2 ...

Takes the arguments of `jaxatt`.  The time holds what a process waits for slower ones.
"""

from __future__ import annotations

import statistics
import sys
import time

import numpy as np
import numpy.typing as npt

from jaxatt.cli import main
from jaxatt.runtime import processes


def counted() -> list[tuple[int, float]]:
    """List that fills with the bytes and the seconds [s] of every exchange from now on."""
    seen: list[tuple[int, float]] = []
    exchange = processes._gathered

    def timed(content: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        began = time.perf_counter()
        found = exchange(content)
        seen.append((len(content), time.perf_counter() - began))
        return found

    processes._gathered = timed
    return seen


if __name__ == "__main__":
    seen = counted()
    try:
        main()
    finally:
        sizes, seconds = [n for n, _ in seen], [s for _, s in seen]
        print(
            f"{len(seen)} exchanges, {sum(sizes)} bytes of this process, {sum(seconds):.2f} s in "
            f"all, median {1e3 * statistics.median(seconds or [0.0]):.1f} ms",
            file=sys.stderr,
        )
