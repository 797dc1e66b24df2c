"""Penalty terms of the Powell-Hestenes-Rockafellar augmented Lagrangian.

Source: Nocedal & Wright, Numerical Optimization (2006), section 17.3.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array


def pushed(multipliers: Array, penalty: Array, values: Array) -> Array:
    """First-order multiplier estimate of inequalities; zero where they hold with room to spare."""
    return jnp.maximum(0.0, multipliers - penalty * values)


def inequality_cost(multipliers: Array, penalty: Array, values: Array) -> Array:
    """Contribution () of inequalities `values >= 0` to the augmented Lagrangian."""
    return jnp.sum(pushed(multipliers, penalty, values) ** 2 - multipliers**2) / (2.0 * penalty)


def equality_cost(multipliers: Array, penalty: Array, values: Array) -> Array:
    """Contribution () of equalities `values == 0` to the augmented Lagrangian."""
    return jnp.sum(multipliers * values + 0.5 * penalty * values**2)
