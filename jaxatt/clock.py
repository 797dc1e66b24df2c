"""Time that JAX spends on tracing and compiling, as JAX itself reports it."""

from __future__ import annotations

import functools

import jax

_EVENTS = ("/jax/core/compile/",)
_seconds = 0.0


def _listen(event: str, duration_secs: float, **_: str | int) -> None:
    global _seconds
    if event.startswith(_EVENTS):
        _seconds += duration_secs


@functools.cache
def _register() -> None:
    jax.monitoring.register_event_duration_secs_listener(_listen)


def compile_seconds() -> float:
    """Seconds spent on tracing, lowering and compiling since the first call of this function."""
    _register()
    return _seconds
