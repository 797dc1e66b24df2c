"""Derivatives of a transcribed interval, for whoever solves the programme over stages.

The error coordinates of the state at its beginning go through the manifold's retraction, the
Runge-Kutta formula and the manifold's difference; each is differentiated by itself.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.optimize.riccati.recursion import product
from jaxatt.optimize.transcription.continuous import Continuous
from jaxatt.optimize.transcription.runge_kutta import Expansion, Interval, Rate, RungeKutta


def rate_of(of: Continuous) -> Rate:
    """Rates of the user's states and of the cost, in units of the horizon; see `RungeKutta`."""

    def rate(y: Array, v: Array, when: Array, p: Any) -> Array:
        x, u, extras = y[: of.states], of.unscaled(v, p), of.extras(y, when, p)
        found = of.dynamics(x, u, p, extras)
        if of.running_cost is not None:
            cost = of.running_cost(x, u, p, extras)
            found = jnp.concatenate([found, jnp.reshape(cost, (1,))])
        return extras.final_time * found

    return rate


class StageDerivatives:
    """`linearisation` and `lagrangian_hessian` of a transcribed programme."""

    def __init__(self, of: Continuous, formula: RungeKutta):
        self.of, self.formula = of, formula

    def _retracted(self, y: Array, error: Array) -> Array:
        assert self.of.retract is not None
        return self.of.retract(y[: self.of.states], error)

    def _missed(self, end: Array, y_next: Array) -> Array:
        """Error of the user's states at the end, (n,)."""
        s = self.of.states
        if self.of.difference is None:
            return end[:s] - y_next[:s]
        return self.of.difference(end[:s], y_next[:s])

    def _spread(self, y: Array) -> Array:
        """Derivative of the user's states by their error coordinates, (s, n)."""
        rest = jnp.zeros(self.of.error_size, y.dtype)
        return jax.jacfwd(lambda e: self._retracted(y, e))(rest)

    def linearisation(
        self, y: Array, u: Array, y_next: Array, interval: Interval, p: Any
    ) -> Linearisation:
        """See `OptimalControlProgram`."""
        s, n, decided = self.of.states, self.of.error_size, self.of.decided
        found = self.formula.expand(y, u, interval, p)
        missed = self._missed(found.end, y_next)
        by_end, by_cost = found.by_end, found.by_cost
        if self.of.retract is not None:
            by_next = jax.jacfwd(self._missed)(found.end[:s], y_next)
            spread = self._spread(y)
            by_end = product(by_next, by_end)
            by_end = jnp.concatenate([product(by_end[:, :s], spread), by_end[:, s:]], axis=1)
            first = jnp.sum(by_cost[:s, None] * spread, axis=0)
            by_cost = jnp.concatenate([first, by_cost[s:]])
        gap = jnp.concatenate([missed, y[s:] - y_next[s:]])
        still = jnp.eye(n + decided, by_end.shape[1], dtype=y.dtype)[n:]
        dynamics = jnp.concatenate([by_end, still])
        return Linearisation(gap, dynamics, by_cost, found)

    def lagrangian_hessian(
        self,
        y: Array,
        u: Array,
        y_next: Array,
        interval: Interval,
        p: Any,
        costate: Array,
        kept: Expansion,
    ) -> Array:
        """See `OptimalControlProgram`."""
        s, n = self.of.states, self.of.error_size
        if self.of.retract is None:
            return self.formula.bend(kept.points, interval, costate[:n], p).hessian
        end, costate = kept.end[:s], costate[:n]

        def valued(end: Array) -> Array:
            return jnp.sum(costate * self._missed(end, y_next))

        at_end = jax.grad(valued)(end)
        bent = self.formula.bend(kept.points, interval, at_end, p)
        curved = jax.hessian(valued)(end)
        hessian = bent.hessian + product(kept.by_end.T, product(curved, kept.by_end))
        spread = self._spread(y)
        hessian = jnp.concatenate([product(spread.T, hessian[:s]), hessian[s:]])
        hessian = jnp.concatenate([product(hessian[:, :s], spread), hessian[:, s:]], axis=1)

        def started(error: Array) -> Array:
            return jnp.sum(by_start * self._retracted(y, error))

        by_start = bent.by_start
        turned = jax.hessian(started)(jnp.zeros(n, y.dtype))
        size = hessian.shape[0] - n
        return hessian + jnp.pad(turned, ((0, size), (0, size)))
