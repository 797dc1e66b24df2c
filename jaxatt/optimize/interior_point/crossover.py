"""Complementarity pairs of slack s and multiplier z, each linearised for a Newton step.

A pair's multiplier after a step is  z = intercept - stiffness ds.  Under a barrier b the line is
the tangent of  s z = b.  Once it is known which limits hold (the active set), it is  s = 0  or  z =
0 itself, and Newton's method ends in a few steps even where a limit holds with hardly any force,
where the pairs of a barrier problem only halve from step to step.

Sources: Hintermueller, Ito and Kunisch (2002), "The primal-dual active set strategy as a semismooth
Newton method"; El-Bakry, Tapia and Zhang (1994), "A study of indicators for identifying zero
variables in interior-point methods", for the first guess of what holds.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded


class Pairs(NamedTuple):
    """Linear relation z = intercept - stiffness ds that each pair obeys after a step."""

    stiffness: Bounded
    intercept: Bounded


def barrier_pairs(slack: Bounded, dual: Bounded, barrier: Array) -> Pairs:
    """Pairs that head for s z = barrier."""
    return Pairs(
        jax.tree.map(lambda z, s: z / s, dual, slack),
        jax.tree.map(lambda s: barrier / s, slack),
    )


def active_pairs(active: Bounded, slack: Bounded, dual: Bounded, penalty: Array) -> Pairs:
    """Pairs that head for s = 0 at active limits, by a large penalty, and for z = 0 elsewhere."""
    return Pairs(
        jax.tree.map(lambda a: jnp.where(a, penalty, 0.0), active),
        jax.tree.map(lambda a, s, z: jnp.where(a, z - penalty * s, 0.0), active, slack, dual),
    )


def active_after(active: Bounded, slack: Bounded, dual: Bounded) -> Bounded:
    """Active set after a step: active limits with z > 0, and limits that were overstepped."""
    return jax.tree.map(lambda a, s, z: jnp.where(a, z > 0.0, s < 0.0), active, slack, dual)


def active_along(slack: Bounded, dual: Bounded, by_slack: Bounded, by_dual: Bounded) -> Bounded:
    """Limits whose slack shrinks more along a step, in proportion, than their multiplier."""
    return jax.tree.map(lambda s, z, ds, dz: z * ds < s * dz, slack, dual, by_slack, by_dual)
