"""Riccati recursion of a Newton step, for many starts side by side.

All arrays have one more axis behind those that are named, of lanes (`jaxatt.optimize.lanes`).
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.lanes import computed_once
from jaxatt.optimize.riccati.recursion import eliminated, product


class Stages(NamedTuple):
    """Quadratic model of all stages in the error state, n coordinates, then the b controls.

    dynamics : (N, n, n + b).  hessian : (N, n + b, n + b).  gradient : (N, n + b).  gap : (N, n).
    """

    dynamics: Array
    hessian: Array
    gradient: Array
    gap: Array


class Backwards(NamedTuple):
    """What is still to come, and what to do.

    value : (n, n + 1), Hessian and gradient of the cost at the first node; values : (N, n, n + 1),
    at those after it.  laws : (N, b, n + 1), gains on the error state, then the constant.
    pivot : (), the least of the eliminations; positive where every one was a minimum.
    """

    value: Array
    values: Array
    laws: Array
    pivot: Array


def times(matrix: Array, vector: Array) -> Array:
    """Product of (p, q) and (q,)."""
    total = matrix[:, 0] * vector[:1]
    for k in range(1, matrix.shape[1]):
        total = total + matrix[:, k] * vector[k : k + 1]
    return total


def backwards(stages: Stages, end: Array) -> Backwards:
    """Minimise over the controls from the last stage to the first.

    end : (n, n + 1), Hessian and gradient of the cost at the last node.
    """
    n, count = end.shape[0], stages.gap.shape[0]

    def ahead(value: Array, dynamics: Array, gap: Array) -> tuple[Array, Array]:
        curving = value[:, :n]
        return product(curving, dynamics), value[:, n] + times(curving, gap)

    def stage(
        carry: tuple[Array, Array], inputs: tuple[Stages, Array]
    ) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        value, least = carry
        (dynamics, hessian, gradient, gap), index = inputs
        pushed, pull = computed_once(ahead, index >= 0)(value, dynamics, gap)
        turned = jnp.swapaxes(dynamics, 0, 1)
        hessian = hessian + product(turned, pushed)
        gradient = gradient + times(turned, pull)
        left = eliminated(hessian, gradient, n)
        symmetric = 0.5 * (left.hessian + jnp.swapaxes(left.hessian, 0, 1))
        before = jnp.concatenate([symmetric, left.gradient[:, None]], axis=1)
        return (before, jnp.minimum(least, left.pivot)), (left.law, value)

    unlimited = jnp.full(end.shape[2:], jnp.inf, end.dtype)
    (value, least), (laws, values) = lax.scan(
        stage, (end, unlimited), (stages, jnp.arange(count)), reverse=True
    )
    return Backwards(value, values, laws, least)


def forwards(begin: Array, stages: Stages, laws: Array) -> tuple[Array, Array, Array]:
    """Errors of the states (N, n) and of the last one (n,), and controls (N, b), under the laws."""

    def stage(x: Array, inputs: tuple[Stages, Array]) -> tuple[Array, tuple[Array, Array]]:
        (dynamics, _, _, gap), law = inputs
        n = x.shape[0]
        u = law[:, n] + times(law[:, :n], x)
        return times(dynamics, jnp.concatenate([x, u])) + gap, (x, u)

    end, (x, u) = lax.scan(stage, begin, (stages, laws))
    return x, end, u


class Newton(NamedTuple):
    """A step: x (N, n), end (n,), u (N, b), costates (N, n) by it, and the least pivot ()."""

    x: Array
    end: Array
    u: Array
    costates: Array
    pivot: Array


def solved(stages: Stages, end: Array, costate: Array, free_start: int) -> Newton:
    """Minimise the quadratic model of all stages.

    costate : (n,), what the gradient at the first node lacks of the Lagrangian's.
    free_start : number of last coordinates of the first state that are free.
    """
    n = end.shape[0]
    lanes = jnp.broadcast_shapes(*(leaf.shape[-1:] for leaf in (*stages, end, costate)))
    end, costate = (jnp.broadcast_to(leaf, (*leaf.shape[:-1], *lanes)) for leaf in (end, costate))
    back = backwards(stages, end)
    begin, least = jnp.zeros_like(costate), back.pivot
    if free_start:
        first = n - free_start
        left = eliminated(back.value[:, :n], back.value[:, n] + costate, first)
        begin = jnp.concatenate([begin[:first], left.law[:, first]])
        least = jnp.minimum(least, left.pivot)
    x, last, u = forwards(begin, stages, back.laws)
    following = jnp.concatenate([x[1:], last[None]])
    costates = back.values[:, :, n]
    for k in range(n):
        costates = costates + back.values[:, :, k] * following[:, k : k + 1]
    return Newton(x, last, u, costates, least)
