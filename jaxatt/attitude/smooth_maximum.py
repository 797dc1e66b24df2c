"""Positive part and magnitude of a number, exact or with rounded corners."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar


def positive_part(value: Scalar, smoothing: Scalar = 0.0) -> Array:
    """The larger of zero and a value, (value + sqrt(value^2 + smoothing)) / 2.

    value : any shape.  smoothing : alpha, in squared units of the value; 0 is exact.
    Source: Kristiansen (2023), eq. (2.11) with x_2 = 0.
    """
    return 0.5 * (value + _rounded(jnp.asarray(value), smoothing))


def magnitude(value: Scalar, smoothing: Scalar = 0.0) -> Array:
    """The larger of a value and its negative, sqrt(4 value^2 + smoothing) / 2.

    value, smoothing : as in `positive_part`.  Source: Kristiansen (2023), eq. (2.11).
    """
    return 0.5 * _rounded(2.0 * jnp.asarray(value), smoothing)


def _rounded(value: Array, smoothing: Scalar) -> Array:
    squared = value * value + smoothing
    corner = squared == 0.0
    return jnp.where(corner, 0.0, jnp.sqrt(jnp.where(corner, 1.0, squared)))
