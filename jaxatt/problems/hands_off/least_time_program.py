"""Programme for the least final time of a fixed support, with time dilation.

Time is dilated: the variables are the scaled controls and, in a column of their own, the logarithm
r of the step's ratio to the plant's.  The plant's tables stay as they are by interval: what moves
along the orbit is a little too fast or too slow until they are made again for the step found.
"""

from __future__ import annotations

import functools

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.program import Program
from jaxatt.problems.hands_off.sparse_program import SparseArguments, SparseSystem


def controls_of(x: Array) -> Array:
    """Scaled controls (N, b), taken from the variables (N, b + 1)."""
    return x[:, :-1]


def log_ratio(x: Array) -> Array:
    """Log of the time dilation r; the other entries of its column are held at zero."""
    return x[0, -1]


@functools.cache
def least_time_program(system: SparseSystem) -> Program:
    """Programme that minimises r subject to the rows, limits and path constraints.

    The objective is linear, so the smoothing enters as curvature alone, as in `slack_program`.
    """

    def plant(x: Array, args: SparseArguments) -> object:
        return system.stretched(args.plant, jnp.exp(log_ratio(x)))

    def curvature(x: Array, args: SparseArguments, smoothing: Array) -> Array:
        eye = jnp.eye(x.shape[1], dtype=x.dtype)[None]
        return smoothing * jnp.repeat(eye, x.shape[0], axis=0)

    def free(x: Array, args: SparseArguments) -> Array:
        column = jnp.zeros((x.shape[0], 1), x.dtype).at[0, 0].set(1.0)
        return jnp.concatenate([args.free, column], axis=1)

    return Program(
        objective=lambda x, args, smoothing: log_ratio(x),
        curvature=curvature,
        equality=lambda x, args: system.rows(controls_of(x), plant(x, args)),
        inequality=lambda x, args: system.margins(controls_of(x), plant(x, args)),
        stage_inequality=lambda x, args: system.stage_margins(controls_of(x), args.plant),
        free=free,
    )
