"""Motion along an orbit: position and velocity at any time, for all that depends on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import jax
from jax import Array

from jaxatt.environment import kepler, orbit


class OrbitState(NamedTuple):
    """Where a satellite is, in inertial axes.

    position : (..., 3) [m].  velocity : (..., 3) [m/s].
    acceleration : (..., 3) [m/s^2]; None where it lies in the plane of the orbit, which then does
    not turn.
    """

    position: Array
    velocity: Array
    acceleration: Array | None = None


class Motion(Protocol):
    """A motion about the Earth, as a pytree: what compiled code knows of an orbit.

    mu : () [m^3/s^2], the Earth's gravitational parameter.
    """

    @property
    def mu(self) -> Array | float: ...

    def at(self, time: Array) -> OrbitState:
        """State at times (...) [s] after time zero."""
        ...


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TwoBody:
    """Motion on an ellipse that stays as it is.

    elements : at time zero, in inertial axes (J2000).  mu : () [m^3/s^2].
    """

    elements: kepler.KeplerianElements
    mu: Array | float

    def at(self, time: Array) -> OrbitState:
        """State at times (...) [s] after time zero."""
        r_i, v_i = kepler.to_state(self.elements, self.mu)
        return OrbitState(*orbit.propagate(r_i, v_i, time, self.mu))
