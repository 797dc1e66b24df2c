"""Functions of arrays that run as one program where they are called with numbers."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

import jax

F = TypeVar("F", bound=Callable[..., Any])


def compiled_whole(function: F) -> F:
    """Compile a function of arrays for calls with numbers, which would compile every operation.

    Where a larger function is traced, the function is part of it as if it were not wrapped.
    """
    run = jax.jit(function)

    @functools.wraps(function)
    def called(*args: Any, **named: Any) -> Any:
        traced = any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves((args, named)))
        return (function if traced else run)(*args, **named)

    return cast(F, called)
