"""Wall-clock time spent on tracing and compiling, as JAX reports it.

Programs compile side by side, and what JAX reports of one contains what it reports of another, so
what counts is the time in which at least one was at work.
"""

from __future__ import annotations

import functools
import time

import jax

_EVENTS = ("/jax/core/compile/",)
_spans: list[tuple[float, float]] = []


def _listen(event: str, duration_secs: float, **_: str | int) -> None:
    if event.startswith(_EVENTS):
        end = time.perf_counter()
        _spans.append((end - duration_secs, end))


@functools.cache
def _register() -> None:
    jax.monitoring.register_event_duration_secs_listener(_listen)


def covered(spans: list[tuple[float, float]]) -> float:
    """Total length of the union of intervals (begin, end)."""
    total, reach = 0.0, float("-inf")
    for begin, end in sorted(spans):
        total += max(0.0, end - max(begin, reach))
        reach = max(reach, end)
    return total


def compile_seconds() -> float:
    """Seconds spent on tracing, lowering and compiling since the first call of this function."""
    _register()
    return covered(list(_spans))
