"""Call a user's functions with the arguments that they name."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array


class Extras(NamedTuple):
    """Arguments that a function receives if it has one of that name.

    time : () [s].  final_time : () [s].  free : (m,), the free parameters.
    """

    time: Array
    final_time: Array
    free: Array


def takes_extras(
    function: Callable[..., Any], name: str, plain: tuple[str, ...]
) -> Callable[..., Array]:
    """Wrap a function so that it takes its plain arguments and then `Extras`.

    name : of the function, for complaints.  plain : names of the arguments that every such function
    has, in their order.
    """
    if not callable(function):
        raise ValueError(f"{name} is {function!r}; a function of ({', '.join(plain)}) is expected")
    parameters = list(inspect.signature(function).parameters.values())
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        wanted: list[str] = []
    else:
        own = [p for p in parameters if p.kind is not p.VAR_KEYWORD]
        wanted = [p.name for p in own[len(plain) :] if p.default is p.empty or _known(p.name)]
        if len(own) < len(plain) or not all(map(_known, wanted)):
            raise ValueError(
                f"{name} takes ({', '.join(p.name for p in own)}); expected are "
                f"({', '.join(plain)}) and then any of {', '.join(Extras._fields)}"
            )

    def called(*args: Any) -> Array:
        *given, extras = args
        return jnp.asarray(function(*given, **{key: getattr(extras, key) for key in wanted}))

    return called


def _known(name: str) -> bool:
    return name in Extras._fields
