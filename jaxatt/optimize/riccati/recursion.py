"""Riccati recursion: the Newton step of a programme whose stages are tied by dynamics.

Backwards over the stages the quadratic model of what is still to come is minimised over the
controls, which leaves a feedback law; forwards the dynamics are flown under it.  The cost grows
with the number of stages, not with its cube.

Matrices of a stage are small arrays and their products sums of rank-one products: under `jax.vmap`
with the batch axis last each of those is one elementwise operation over the batch, which is several
times faster on a CPU than a matrix product for every member of it.

Sources: Mayne (1966), "A second-order gradient method for determining optimal trajectories of
non-linear discrete-time systems"; Howell, Jackson and Manchester (2019), "ALTRO: a fast solver for
constrained trajectory optimization"; Giftthaler et al. (2018), "A family of iterative Gauss-Newton
shooting methods for nonlinear optimal control".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.optimal_control import OptimalControlProgram

Limiter = Callable[[Array], tuple[Array, Array]]
"""u (b,) -> controls within their limits (b,), and 1 where that changed them, ()."""


class StageModel(NamedTuple):
    """Quadratic model of one stage in the error state, n coordinates, then the b controls.

    dynamics : (n, n + b), derivatives of the next error state.
    hessian : (n + b, n + b), positive semidefinite.  gradient : (n + b,).
    """

    dynamics: Array
    hessian: Array
    gradient: Array


class Trajectory(NamedTuple):
    """States and controls of a simulated trajectory.

    x : (N, s), states at nodes 0 to N - 1.  end : (s,), state at node N.  u : (N, b).
    """

    x: Array
    end: Array
    u: Array


def product(a: Array, b: Array) -> Array:
    """Matrix product of (p, q) and (q, r) as a sum of rank-one products."""
    total = a[:, :1] * b[:1]
    for k in range(1, a.shape[1]):
        total = total + a[:, k : k + 1] * b[k : k + 1]
    return total


class Eliminated(NamedTuple):
    """Quadratic model after some variables were minimised out.

    hessian : (n, n) and gradient : (n,), in the others.  law : (b, n + 1), the variables eliminated
    by the others, the constant last.  pivot : (), the least; positive where it was a minimum.
    """

    hessian: Array
    gradient: Array
    law: Array
    pivot: Array


def eliminated(hessian: Array, gradient: Array, first: int) -> Eliminated:
    """Minimise a quadratic model (p, p), (p,) over its variables from number `first` on.

    Both may have further axes behind these, of a batch.
    """
    least, rows = jnp.asarray(jnp.inf, gradient.dtype), []
    for k in range(gradient.shape[0] - 1, first - 1, -1):
        pivot, column = hessian[k, k], hessian[:k, k]
        least = jnp.minimum(least, pivot)
        row, rest = hessian[k, :k] / pivot[None], gradient[k] / pivot
        rows.append((row, rest))
        hessian = hessian[:k, :k] - column[:, None] * row[None]
        gradient = gradient[:k] - column * rest[None]
    law: list[Array] = []
    for row, rest in reversed(rows):
        found = -jnp.concatenate([row[:first], rest[None]])
        for j, other in enumerate(law):
            found = found - row[first + j][None] * other
        law.append(found)
    return Eliminated(hessian, gradient, jnp.stack(law), least)


def derivatives_along(program: OptimalControlProgram, flown: Trajectory, args: Any) -> Array:
    """Derivatives of the next error state at every stage, (N, n, n + b).

    A loop of its own: inside the backward recursion XLA would compute them again for every use.
    """
    following = jnp.concatenate([flown.x[1:], flown.end[None]])

    def at(_: None, inputs: tuple[Array, Array, Array, Any]) -> tuple[None, Array]:
        x, x_next, u, stage = inputs
        return None, program.derivatives(x, u, x_next, stage, args)

    inputs = (flown.x, following, flown.u, program.stages(args))
    return lax.scan(at, None, inputs)[1]


class Policy(NamedTuple):
    """Cost-to-go and feedback law of one stage.

    value : (n, n + 1), Hessian and gradient of what is to come, in the error state.
    law : (b, n + 1), gains on the error state, then the change where it is zero.
    slope : () of the model along that change.
    pivot : (), the least of the elimination; the model is convex in the controls if it is positive.
    """

    value: Array
    law: Array
    slope: Array
    pivot: Array


def backward_step(
    value: Array, model: StageModel, free: Array, forced: Array, damping: Array
) -> Policy:
    """One stage of the backward recursion.

    value : (n, n + 1), Hessian and gradient of what is to come in the next error state.
    free : (b,), 1 where a control may move.  forced : (b,), by how much one that may not is moved.
    damping : (), added to the curvature of the controls.
    """
    n = value.shape[0]
    size = model.gradient.shape[0]
    ahead = product(value.T, model.dynamics)
    hessian = model.hessian + product(model.dynamics.T, ahead[:n])
    gradient = model.gradient + ahead[n]
    # Controls that may not move become constants, and their rows say so.
    gradient = gradient + jnp.sum(hessian[:, n:] * forced[None], axis=1)
    moves = jnp.concatenate([jnp.ones(n, value.dtype), free])
    gradient = jnp.concatenate([gradient[:n], gradient[n:] * free])
    diagonal = jnp.concatenate([jnp.zeros(n, value.dtype), damping * free + (1.0 - free)])
    hessian = hessian * moves[:, None] * moves[None, :] + diagonal[:, None] * jnp.eye(size)
    left = eliminated(hessian, gradient, n)
    slope = jnp.sum(gradient[n:] * left.law[:, n])
    law = left.law + jnp.concatenate([jnp.zeros((forced.shape[0], n)), forced[:, None]], axis=1)
    quadratic = 0.5 * (left.hessian + left.hessian.T)
    rest = jnp.concatenate([quadratic, left.gradient[:, None]], axis=1)
    return Policy(rest, law, slope, left.pivot)


def fly_with_feedback(
    program: OptimalControlProgram,
    around: Trajectory,
    laws: Array,
    length: Array,
    args: Any,
    limited: Limiter | None = None,
) -> tuple[Trajectory, Array]:
    """Simulate the dynamics under feedback laws (N, b, n + 1) around a trajectory.

    length : (), share of the change that each law asks for.
    limited : keeps the controls within their limits; without it there are none.

    Returns the trajectory and (N,), 1 where a limit changed the controls.
    """
    states, n = around.x.shape[1], program.error_size

    def advance(x: Array, inputs: tuple[Array, Array, Array, Any]) -> tuple[Array, Array]:
        x_ref, u_ref, law, stage = inputs
        error = program.difference(x, x_ref)
        u = u_ref + length * law[:, n] + jnp.sum(law[:, :n] * error[None], axis=1)
        u, clipped = (u, jnp.zeros(())) if limited is None else limited(u)
        return program.dynamics(x, u, stage, args), jnp.concatenate([x, u, clipped[None]])

    stages = program.stages(args)
    end, out = lax.scan(advance, program.start(args), (around.x, around.u, laws, stages))
    return Trajectory(out[:, :states], end, out[:, states:-1]), out[:, -1]
