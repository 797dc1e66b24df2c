"""The Powell-Hestenes-Rockafellar augmented Lagrangian, one constraint at a time.

Source: Nocedal & Wright, Numerical Optimization (2006), section 17.3.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array


def pushed(multipliers: Array, penalty: Array, values: Array) -> Array:
    """Multiplier estimate of inequalities, zero where they are satisfied with room to spare."""
    return jnp.maximum(0.0, multipliers - penalty * values)


def inequality_cost(multipliers: Array, penalty: Array, values: Array) -> Array:
    """What inequalities `values >= 0` add to the augmented Lagrangian, ()."""
    return jnp.sum(pushed(multipliers, penalty, values) ** 2 - multipliers**2) / (2.0 * penalty)


def equality_cost(multipliers: Array, penalty: Array, values: Array) -> Array:
    """What equalities `values == 0` add to the augmented Lagrangian, ()."""
    return jnp.sum(multipliers * values + 0.5 * penalty * values**2)
