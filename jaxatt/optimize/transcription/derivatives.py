"""First and second derivatives of a transcribed interval.

The error coordinates of the state at its beginning go through the manifold's retraction, the
Runge-Kutta formula and the manifold's difference; each is differentiated by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.optimize.riccati.recursion import product
from jaxatt.optimize.transcription.continuous import Continuous
from jaxatt.optimize.transcription.runge_kutta import Expansion, Interval, Rate, RungeKutta


def rate_of(of: Continuous) -> Rate:
    """Function of the rates of states and cost, in units of the horizon; see `RungeKutta`."""

    def rate(y: Array, v: Array, when: Array, p: Any) -> Array:
        x, u, extras = y[: of.states], of.unscaled(v, p), of.extras(y, when, p)
        found = of.dynamics(x, u, p, extras)
        if of.running_cost is not None:
            cost = of.running_cost(x, u, p, extras)
            found = jnp.concatenate([found, jnp.reshape(cost, (1,))])
        return extras.final_time * found

    return rate


class StageDerivatives:
    """Linearisation and Lagrangian Hessian of a transcribed programme."""

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

    def linearisation(
        self, y: Array, u: Array, y_next: Array, interval: Interval, p: Any
    ) -> Linearisation:
        """See `OptimalControlProgram`."""
        of = self.of
        s, n, decided = of.states, of.error_size, of.decided
        width = n + decided + of.controls
        if of.retract is None:
            found = self.formula.expand(y, u, interval, p)
            missed, by_end = found.end[:s] - y_next[:s], found.by_end
        else:
            rest = jnp.zeros(n, y.dtype)
            spread = jax.jacfwd(lambda e: self._retracted(y, e))(rest)
            spread = jnp.concatenate([spread, jnp.zeros((s, width - n), y.dtype)], axis=1)
            found = self.formula.expand(y, u, interval, p, spread)

            def along(direction: Array) -> tuple[Array, Array]:
                return jax.jvp(
                    lambda end: self._missed(end, y_next), (found.end[:s],), (direction,)
                )

            missed, by_end = jax.vmap(along, in_axes=1, out_axes=(None, 1))(found.by_end)
        gap = jnp.concatenate([missed, y[s:] - y_next[s:]])
        still = jnp.eye(n + decided, width, dtype=y.dtype)[n:]
        return Linearisation(gap, jnp.concatenate([by_end, still]), found.by_cost, found)

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
        costate = costate[:n]
        if self.of.retract is None:
            return self.formula.second_order(kept, interval, costate, p).hessian

        def valued(end: Array) -> Array:
            return jnp.sum(costate * self._missed(end, y_next))

        at_end, curved = _along(valued, kept.end[:s], kept.by_end.T)
        bent = self.formula.second_order(kept, interval, at_end, p)
        hessian = bent.hessian + product(kept.by_end.T, curved.T)

        def started(error: Array) -> Array:
            return jnp.sum(bent.by_start * self._retracted(y, error))

        _, turned = _along(started, jnp.zeros(n, y.dtype), jnp.eye(n, dtype=y.dtype))
        rest = hessian.shape[0] - n
        return hessian + jnp.pad(turned, ((0, rest), (0, rest)))


def _along(function: Callable[[Array], Array], at: Array, directions: Array) -> tuple[Array, Array]:
    """Gradient of a function, and its Hessian along directions (k, size), (k, size).

    A loop, for the reason given in `RungeKutta.second_order`.
    """

    def one(_: None, direction: Array) -> tuple[None, Array]:
        return None, jax.jvp(jax.grad(function), (at,), (direction,))[1]

    return jax.grad(function)(at), lax.scan(one, None, directions)[1]
