"""States that begin with a unit quaternion: steps on their manifold and differences along it.

Errors of the attitude are turns in body axes, four modified Rodrigues parameters long: smooth up to
a full turn from the reference.  The entries after the quaternion are added and subtracted.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array


def retract(x: Array, error: Array) -> Array:
    """State at an error (n,) from x (n + 1,)."""
    a, b, c = (0.25 * error[i] for i in range(3))
    squared = a * a + b * b + c * c
    scale = 1.0 / (1.0 + squared)
    w, v = (1.0 - squared) * scale, tuple(2.0 * scale * m for m in (a, b, c))
    q = (
        x[0] * w - x[1] * v[0] - x[2] * v[1] - x[3] * v[2],
        x[0] * v[0] + x[1] * w + x[2] * v[2] - x[3] * v[1],
        x[0] * v[1] - x[1] * v[2] + x[2] * w + x[3] * v[0],
        x[0] * v[2] + x[1] * v[1] - x[2] * v[0] + x[3] * w,
    )
    return jnp.concatenate([jnp.stack(q), x[4:] + error[3:]])


def difference(x: Array, reference: Array) -> Array:
    """Error (n,) of a state from a reference."""
    r = reference
    w = r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + r[3] * x[3]
    v = (
        r[0] * x[1] - r[1] * x[0] - r[2] * x[3] + r[3] * x[2],
        r[0] * x[2] + r[1] * x[3] - r[2] * x[0] - r[3] * x[1],
        r[0] * x[3] - r[1] * x[2] + r[2] * x[1] - r[3] * x[0],
    )
    scale = 4.0 / jnp.maximum(1.0 + w, 1e-6)
    return jnp.concatenate([jnp.stack([scale * m for m in v]), x[4:] - r[4:]])
