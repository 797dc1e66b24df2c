"""An answer as a function of its parameters, differentiated by the implicit function theorem.

`settled` takes Newton steps on the first-order conditions with given limits active.  Its derivative
does not go through those steps: it is one linear solve with the symmetric KKT matrix, so that
`jax.jvp`, `jax.grad`, `jax.vmap` and second derivatives compose.

Source: Blondel et al. (2022), "Efficient and modular implicit differentiation".
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax
from jax.flatten_util import ravel_pytree

from jaxatt.optimize.sensitivity.conditions import Conditions

_MOST_PASSES = 25
_MOST_STALLS = 3
"""Passes in a row that may leave a larger residual, which the next step may make up for."""
_ROUNDING = 1e-16
"""Residual at which there is nothing left to improve; rounding mostly ends it before."""


def size_of(tree: Any) -> Array:
    """Largest magnitude in a pytree, ()."""
    return jnp.max(jnp.abs(ravel_pytree(tree)[0]), initial=0.0)


def step_of(
    conditions: Conditions, system: Any, point: Any, args: Any, active: Any, right: Any
) -> Any:
    """Step with KKT matrix . step = right, as a linear and symmetric function of `right`.

    system : of `conditions` at the point.
    """
    at, unflat = ravel_pytree(conditions.zero(point))

    def slope(step: Array) -> Array:
        found = jax.grad(lambda s: conditions.lagrangian(point, unflat(s), args, active))(step)
        return jnp.asarray(found)

    def matrix(step: Array) -> Array:
        return jax.jvp(slope, (at,), (step,))[1]

    fixed = lax.stop_gradient(system)

    def inverse(_: Any, right: Array) -> Array:
        return ravel_pytree(conditions.solve(fixed, active, unflat(right)))[0]

    # One vector: the transpose takes a right-hand side that is unknown as a whole.
    whole = ravel_pytree(right)[0]
    return unflat(lax.custom_linear_solve(matrix, whole, inverse, symmetric=True))


class Settled(NamedTuple):
    """A point after Newton steps.

    system : of the conditions there; zeros where the residual is not finite.
    residual : (), of the conditions.  passes : (), those that halved it at least: what gains less
        is rounding, for even where the matrix is singular a step leaves no more than 37 %.
    """

    point: Any
    system: Any
    residual: Array
    passes: Array


def newton(conditions: Conditions, point: Any, args: Any, active: Any) -> Settled:
    """Take Newton steps on the conditions for as long as they reduce the residual, or soon do."""

    system_of = jax.jit(conditions.system)  # traced once, for its shapes and in the loop

    def going(state: tuple[Any, ...]) -> Array:
        return state[-1]

    def onward(state: tuple[Any, ...]) -> tuple[Any, ...]:
        best, size, point, passes, gains, stalls, _ = state
        system = system_of(point, args)
        found = conditions.residual(system, point, active)
        left = size_of(found)
        better = left < size
        best = jax.tree.map(lambda a, b: jnp.where(better, a, b), (point, system), best)
        rounding = left <= _ROUNDING
        step = conditions.solve(system, active, jax.tree.map(jnp.negative, found))
        stalls = jnp.where(better, 0, stalls + 1)
        goes_on = (stalls <= _MOST_STALLS) & ~rounding & (gains < _MOST_PASSES)
        passes = passes + (goes_on & (left < 0.5 * size))
        gains = gains + (goes_on & better)
        size = jnp.where(better, left, size)
        return best, size, conditions.moved(point, step), passes, gains, stalls, goes_on

    shapes = jax.eval_shape(system_of, point, args)
    unknown = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes)
    infinite = jnp.asarray(jnp.inf)
    none = jnp.zeros((), int)
    start = ((point, unknown), infinite, point, none, none, none, jnp.asarray(True))
    (kept, system), size, _, passes, _, _, _ = lax.while_loop(going, onward, start)
    return Settled(kept, system, size, passes)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def settled(conditions: Conditions, args: Any, near: Any, active: Any) -> Any:
    """Point at which the conditions hold, from one nearby; differentiable in `args`.

    near : a point.  active : limits that hold there, and are taken to hold for all `args`.
    """
    return newton(conditions, near, args, active).point


@settled.defjvp
def _settled_jvp(conditions: Conditions, primals: Any, tangents: Any) -> tuple[Any, Any]:
    args, near, active = primals
    point = settled(conditions, args, near, active)
    system = conditions.system(point, args)
    return point, point_along(conditions, system, point, args, active, tangents[0])[1]


def step_along(
    conditions: Conditions, system: Any, point: Any, args: Any, active: Any, along: Any
) -> Any:
    """Step by which an answer moves when its parameters move along a tangent of `args`."""
    right = conditions.pull(point, args, active, along)
    return step_of(conditions, system, point, args, active, right)


def point_along(
    conditions: Conditions, system: Any, point: Any, args: Any, active: Any, along: Any
) -> tuple[Any, Any]:
    """The step of `step_along`, and the tangent of the point."""
    step = step_along(conditions, system, point, args, active, along)
    at = conditions.zero(point)
    return step, jax.jvp(lambda s: conditions.moved(point, s), (at,), (step,))[1]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def value(conditions: Conditions, args: Any, near: Any, active: Any) -> Array:
    """Objective () of the answer; see `settled` for the arguments.

    Its derivative is that of L at fixed variables and multipliers, without any linear solve.
    """
    point = settled(conditions, args, near, active)
    return conditions.objective(point, args)


@value.defjvp
def _value_jvp(conditions: Conditions, primals: Any, tangents: Any) -> tuple[Array, Array]:
    args, near, active = primals
    point = settled(conditions, args, near, active)

    def worth(args: Any) -> Array:
        return conditions.lagrangian(point, conditions.zero(point), args, active)

    change = jax.jvp(worth, (args,), (tangents[0],))[1]
    return conditions.objective(point, args), change
