"""An orbit as a table: sampled once on the host, interpolated in compiled code."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.environment.interpolant import Interpolant, interpolate
from jaxatt.environment.motion import OrbitState
from jaxatt.environment.orbit import MU_EARTH
from jaxatt.runtime.arrays import Floats

States = Callable[[Floats], tuple[Floats, Floats]]
"""Times (n,) [s] -> positions (n, 3) [m] and velocities (n, 3) [m/s] in inertial axes."""

TOLERANCE = 0.01
"""[m] By which the interpolation may miss."""

_ANGLE = 0.1  # [rad] of the orbit between two nodes at first
_FEWEST, _MOST = 16, 2**20  # segments at first
_HALVINGS = 8
_SLACK = 1e-6  # of a segment, for rounding at the ends


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Ephemeris:
    """Motion along an orbit that was sampled; make one with `sampled`.

    table : position and velocity, six channels.  mu : () [m^3/s^2].
    """

    table: Interpolant
    mu: Array | float

    def at(self, time: Array) -> OrbitState:
        """State at times (...) [s] after time zero; not a number outside the table."""
        return _at(self.table, jnp.asarray(time))


@jax.jit
def _at(table: Interpolant, time: Array) -> OrbitState:
    first, step = jnp.asarray(table.first), jnp.asarray(table.step)
    count = jnp.asarray(table.coefficients).shape[0]
    position = (time - first) / step
    inside = (position > -_SLACK) & (position < count + _SLACK)
    values, rates, _ = jax.vmap(table.to_second_order)(jnp.ravel(time))
    values, rates = (part.reshape(*time.shape, 6) for part in (values, rates))
    values = jnp.where(inside[..., None], values, jnp.nan)
    return OrbitState(values[..., :3], values[..., 3:], rates[..., 3:])


def sampled(
    states: States,
    first: float,
    last: float,
    mu: float = MU_EARTH,
    tolerance: float = TOLERANCE,
) -> Ephemeris:
    """Sample an orbit between two times [s], densely enough to be right between the nodes.

    states : also called some nodes outside.
    tolerance : [m], of the position halfway between two nodes, where the interpolation is worst.
    The number of segments is a power of two, so that another orbit over the same time seldom has
    another shape, for which code would be compiled anew.

    Raises `ValueError` where the motion is too rough for any spacing.
    """

    def values(times: Floats) -> Floats:
        return np.concatenate(states(times), axis=1)

    r, v = states(np.linspace(first, last, 65))
    rate = np.linalg.norm(np.cross(r, v), axis=1).max() / np.square(r).sum(axis=1).min()
    least = max(float(_FEWEST), (last - first) * float(rate) / _ANGLE)
    if not least < _MOST:
        raise ValueError(
            f"{last - first:.3g} s of the orbit are more than can be sampled, {least:.3g} segments"
        )
    count = 2 ** math.ceil(math.log2(least))
    for _ in range(_HALVINGS):
        step = (last - first) / count
        table = interpolate(values, first, last, step)
        missed = _between(table, states)
        if missed < tolerance:
            numbers = (jnp.asarray(value) for value in (first, step, table.coefficients, mu))
            start, width, coefficients, parameter = numbers
            return Ephemeris(Interpolant(start, width, coefficients), parameter)
        count *= 2
    raise ValueError(
        f"the orbit is too rough to be interpolated: with nodes {step:.3g} s apart it is still "
        f"missed by {missed:.3g} m between them"
    )


def _between(table: Interpolant, states: States) -> float:
    """Largest error [m] of the position halfway between the nodes."""
    coefficients = np.asarray(table.coefficients)
    halves = 0.5 ** np.arange(6.0)
    found = np.einsum("k,skc->sc", halves, coefficients[:, :, :3])
    nodes = np.arange(len(coefficients), dtype=np.float64)
    middles = float(table.first) + float(table.step) * (nodes + 0.5)
    return float(np.linalg.norm(found - states(middles)[0], axis=1).max())
