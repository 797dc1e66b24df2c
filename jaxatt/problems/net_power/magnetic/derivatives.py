"""First and second derivatives of a stage: an interval, and how it misses the next state."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Vector
from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.blocks import (
    on_rows,
    pulled_slope,
    small_slope,
    times,
    total,
    transposed,
    turn,
)
from jaxatt.problems.net_power.magnetic.expansion import Expansion
from jaxatt.problems.net_power.magnetic.interval import MagneticInterval
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.rows import MOVING, WIDTH


class StageDerivatives:
    """Functions of `OptimalControlProgram` with the names that they have there."""

    def __init__(self, form: MagneticForm):
        self.form, self.interval = form, MagneticInterval(form)

    def moved(
        self, x: Array, u: Array, stage: Interval, p: MagneticParameters, finer: int = 1
    ) -> tuple[Array, Array]:
        """State at the end (8,), and cost ()."""
        end, cost = self.interval.step(x, u, stage, p, finer)
        return jnp.concatenate([retract(x[:4], end[:3]), end[3:], x[-1:]]), cost

    def linearisation(
        self, x: Array, u: Array, x_next: Array, stage: Interval, p: MagneticParameters
    ) -> Linearisation:
        """Gap to the next state and cost, to first order."""
        found = self.interval.expand(x, u, stage, p)
        missed = difference(retract(x[:4], found.end[:3]), x_next[:4])
        gap = jnp.concatenate([missed, found.end[3:] - x_next[4:7], x[-1:] - x_next[-1:]])
        by_turn = times(turn(_three(missed)).rate, turn(_three(found.end)).small)
        still = jnp.eye(1, WIDTH, MOVING, dtype=x.dtype)
        rows = jnp.stack(on_rows(by_turn, list(found.by_end[:3])))
        dynamics = jnp.concatenate([rows, found.by_end[3:], still])
        return Linearisation(gap, dynamics, found.by_cost, found)

    def lagrangian_hessian(
        self,
        x: Array,
        u: Array,
        x_next: Array,
        stage: Interval,
        p: MagneticParameters,
        costate: Array,
        kept: Expansion,
    ) -> Array:
        """Second derivatives (10, 10) of cost + costate . gap, or of the cost alone."""
        if not self.form.exact:
            return self.interval.gauss_newton(kept, x, u, stage, p)
        missed = turn(_three(difference(retract(x[:4], kept.end[:3]), x_next[:4])))
        ended = turn(_three(kept.end))
        force = _three(costate)
        felt = transposed(missed.rate) @ force
        pulled = transposed(ended.small) @ felt
        bent = total(
            times(
                transposed(ended.small),
                times(pulled_slope(missed, force), times(missed.rate, ended.small)),
            ),
            small_slope(ended, felt),
        )
        at_end = jnp.stack([*pulled.parts, *(costate[i] for i in range(3, MOVING))])
        whole = self.interval.second_order(kept, x, u, stage, at_end, p)
        turns = list(kept.by_end[:3])
        for row, curved in zip(turns, on_rows(bent, turns), strict=True):
            whole = whole + row[:, None] * curved[None, :]
        return 0.5 * (whole + whole.T)


def _three(v: Array) -> Vector:
    return Vector(v[0], v[1], v[2])
