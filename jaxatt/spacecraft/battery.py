"""A battery with losses on the way in and on the way out."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from jaxatt.attitude.whole import compiled_whole
from jaxatt.spacecraft.parts.battery import battery as battery
from jaxatt.spacecraft.pytrees import Battery as Battery


@compiled_whole
def charge_along(changes: Any, start: Any, capacity: Any) -> jax.Array:
    """Charge [J] after each of n intervals, with the start in front, (..., n + 1).

    changes : (..., n) [J], what the battery keeps or loses in each interval; see `Battery.net`.
    start : (...) [J], charge before the first.  capacity : (...) [J]; inf where it is not known.
    A full battery takes no more.  An empty one goes below zero, which tells how much is missing.
    """
    steps = jnp.asarray(changes, float)
    lead = steps.shape[:-1]
    first, most = (jnp.broadcast_to(value, lead)[..., None] for value in (start, capacity))
    free = jnp.concatenate([first, first + jnp.cumsum(steps, axis=-1)], axis=-1)
    over = jax.lax.cummax(free - most, axis=free.ndim - 1)
    return free - jnp.maximum(over, 0.0)
