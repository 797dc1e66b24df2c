"""Smooth interpolation of a table in time, cheap to evaluate and to differentiate.

Between two nodes stands the polynomial of fifth degree that has their values, slopes and second
derivatives: twice continuously differentiable, and as good as the table's step to the sixth power.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats

_REACH = 4
"""Nodes either side from which the derivatives at a node are taken."""
_SLOPE = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_BEND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
"""Central differences of eighth order."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Interpolant:
    """Piecewise polynomial of several channels; make one with `interpolate`.

    first : () [s], time of the first node.  step : () [s], between nodes.
    coefficients : (segments, 6, channels), of the powers of the time within a segment in units of
    the step.
    """

    first: Array | float
    step: Array | float
    coefficients: Array | Floats

    def at(self, time: Array) -> Array:
        """Values (channels,) at a time () [s]; beyond its ends the last polynomial goes on."""
        rows, within = self._segment(time)
        total = rows[5]
        for power in (4, 3, 2, 1, 0):
            total = total * within + rows[power]
        return total

    def to_second_order(self, time: Array) -> tuple[Array, Array, Array]:
        """Values, rates [1/s] and second derivatives [1/s^2] at a time (), (channels,) each."""
        rows, within = self._segment(time)
        value, slope, bend = rows[5], jnp.zeros_like(rows[5]), jnp.zeros_like(rows[5])
        for power in (4, 3, 2, 1, 0):
            bend = bend * within + 2.0 * slope
            slope = slope * within + value
            value = value * within + rows[power]
        return value, slope / self.step, bend / self.step**2

    def _segment(self, time: Array) -> tuple[Array, Array]:
        table = jnp.asarray(self.coefficients)
        position = (time - self.first) / self.step
        index = jnp.clip(jnp.floor(position), 0.0, table.shape[0] - 1.0)
        return table[index.astype(int)], position - index


def interpolate(
    values: Callable[[Floats], Floats], first: float, last: float, step: float
) -> Interpolant:
    """Interpolate a smooth function, times (n,) [s] -> (n, channels), between two times.

    step : [s], small against its fastest change.  It is also called a little outside.
    """
    segments = max(1, int(np.ceil((last - first) / step - 1e-9)))
    times = first + step * np.arange(-_REACH, segments + 1 + _REACH, dtype=np.float64)
    table: Floats = np.asarray(values(times), np.float64)
    near = np.lib.stride_tricks.sliding_window_view(table, 2 * _REACH + 1, axis=0)
    f: Floats = table[_REACH:-_REACH]
    g: Floats = near @ _SLOPE
    h: Floats = near @ _BEND
    rise = f[1:] - f[:-1]
    coefficients = np.stack(
        [
            f[:-1],
            g[:-1],
            0.5 * h[:-1],
            10.0 * rise - 6.0 * g[:-1] - 4.0 * g[1:] - 1.5 * h[:-1] + 0.5 * h[1:],
            -15.0 * rise + 8.0 * g[:-1] + 7.0 * g[1:] + 1.5 * h[:-1] - h[1:],
            6.0 * rise - 3.0 * (g[:-1] + g[1:]) + 0.5 * (h[1:] - h[:-1]),
        ],
        axis=1,
    )
    return Interpolant(first, step, coefficients)
