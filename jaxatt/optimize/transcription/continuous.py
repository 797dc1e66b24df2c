"""An optimal-control problem in continuous time, as the user states it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.transcription.signatures import Extras
from jaxatt.runtime.arrays import Floats

Row = Callable[..., Array]
Bounds = Callable[[Any], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class Continuous:
    """Functions of x (s,), u (b,), the parameters and `Extras`; None where there is none.

    states : s.  controls : b.  error_size : coordinates of a state's error.
    initial_state : parameters -> (s,).  duration : parameters -> () [s], None where it is free.
    time_bounds : shortest and longest final time [s] where it is free.
    free_lower, free_upper : (m,), bounds of the free parameters.
    control_bounds : parameters -> lower and upper, (b,) each.
    state_lower, state_upper : (s,), may hold infinities.
    """

    states: int
    controls: int
    error_size: int
    dynamics: Row
    initial_state: Callable[[Any], Array]
    duration: Callable[[Any], Array] | None
    time_bounds: tuple[float, float]
    free_lower: Floats
    free_upper: Floats
    control_bounds: Bounds | None
    state_lower: Floats
    state_upper: Floats
    running_cost: Row | None
    terminal_cost: Row | None
    path_equality: Row | None
    path_inequality: Row | None
    terminal_equality: Row | None
    terminal_inequality: Row | None
    retract: Callable[[Array, Array], Array] | None
    difference: Callable[[Array, Array], Array] | None

    @property
    def parameters(self) -> int:
        """Number m of free parameters."""
        return len(self.free_lower)

    @property
    def decided(self) -> int:
        """Number of decided coordinates of the first state: free parameters and final time."""
        return self.parameters + (self.duration is None)

    @property
    def total(self) -> int:
        """Number of states of a stage: the user's, free parameters, log of the time."""
        return self.states + self.decided

    def final_time(self, y: Array, p: Any) -> Array:
        """Final time () [s] in a state of the stages."""
        return jnp.exp(y[-1]) if self.duration is None else self.duration(p)

    def free(self, y: Array) -> Array:
        """Free parameters, (m,), in a state of the stages."""
        return y[self.states : self.states + self.parameters]

    def extras(self, y: Array, when: Array, p: Any) -> Extras:
        """Arguments that a function may ask for by name; when : () in units of the horizon."""
        final = self.final_time(y, p)
        return Extras(when * final, final, self.free(y))

    def scale(self, p: Any) -> tuple[Array, Array]:
        """Middle and half range of the controls, (b,); 0 and 1 where they have no two bounds."""
        if self.control_bounds is None:
            return jnp.zeros(self.controls), jnp.ones(self.controls)
        lower, upper = self.control_bounds(p)
        both = jnp.isfinite(lower) & jnp.isfinite(upper) & (upper > lower)
        low, high = jnp.where(both, lower, -1.0), jnp.where(both, upper, 1.0)
        return 0.5 * (low + high), 0.5 * (high - low)

    def unscaled(self, v: Array, p: Any) -> Array:
        """Convert controls of the stages to the user's units."""
        middle, half = self.scale(p)
        return middle + half * v

    def guess(self, p: Any) -> Array:
        """Initial state of the stages before anything is decided, (S,)."""
        parts = [self.initial_state(p)]
        if self.parameters:
            parts.append(jnp.asarray(_inside(self.free_lower, self.free_upper)))
        if self.duration is None:
            parts.append(jnp.log(jnp.asarray([_middle_time(*self.time_bounds)])))
        return jnp.concatenate(parts)


def _inside(lower: Floats, upper: Floats) -> Floats:
    """A value within each pair of bounds: the middle, or near the one that there is."""
    low, high = np.isfinite(lower), np.isfinite(upper)
    below, above = np.where(low, lower, 0.0), np.where(high, upper, 0.0)
    alone = np.where(low, np.maximum(below + 1.0, 0.0), np.minimum(above - 1.0, 0.0))
    return np.where(low & high, 0.5 * (below + above), np.where(low | high, alone, 0.0))


def _middle_time(shortest: float, longest: float) -> float:
    if np.isfinite(longest):
        return float(np.sqrt(shortest * longest)) if shortest > 0.0 else 0.5 * longest
    return 2.0 * shortest if shortest > 0.0 else 1.0
