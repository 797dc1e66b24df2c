"""What the Riccati solvers see: a programme whose stages are tied by dynamics (single shooting).

The state may live on a manifold.  Derivatives are taken in an error state of n coordinates around
it, which `retract` and `difference` define; an attitude then has three of them and none of the
solvers meets the singular direction of its quaternion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax


def _no_rows(x: Array, u: Array, stage: Any, args: Any) -> Array:
    return jnp.zeros((0,), x.dtype)


def _no_final_rows(x: Array, args: Any) -> Array:
    return jnp.zeros((0,), x.dtype)


def _hard(stage: Any, args: Any) -> Array:
    return jnp.asarray(jnp.inf)


def _hard_at_the_end(args: Any) -> Array:
    return jnp.asarray(jnp.inf)


def _all_free(stage: Any, args: Any) -> Array:
    return jnp.ones(())


def _no_limits(stage: Any, args: Any) -> tuple[Array, Array]:
    return jnp.asarray(-jnp.inf), jnp.asarray(jnp.inf)


def _plus(x: Array, error: Array) -> Array:
    return x + error


def _minus(x: Array, reference: Array) -> Array:
    return x - reference


class Linearisation(NamedTuple):
    """A stage's dynamics and cost to first order in z, its n error coordinates and b controls.

    gap : (n,), the next state that the dynamics give less the one that there is.
    dynamics : (n, n + b), derivatives of the gap.  cost : (n + b,), those of the cost.
    """

    gap: Array
    dynamics: Array
    cost: Array


@dataclass(frozen=True)
class OptimalControlProgram:
    """Pure functions of states x (s,), controls u (b,), what a stage has, and a pytree `args`.

    Everything that can change from one solve to the next belongs in `args`; what changes from
    stage to stage is a row of `stages`.

    start : args -> (s,), state at the first node.
    stages : args -> pytree with leading axis N.
    dynamics : (x, u, stage, args) -> (s,), state at the next node.
    cost : (x, u, stage, args, smoothing) -> ().
    curvature : (x, u, stage, args, smoothing) -> (n + b, n + b), positive semidefinite, in the
        error state, then the controls; it may majorise the cost rather than be its Hessian.
    error_size : n.
    retract : (x, e) -> (s,), the state at an error e from x; difference : (x, reference) -> e
        such that retract(reference, e) = x, and zero where they agree.
    equality : (x, u, stage, args) -> (q,), zero when satisfied.  equality_weight : (stage, args)
        -> (q,) or (); inf makes a row hard, w costs w/2 row^2, and 0 leaves it out.
    inequality : (x, u, stage, args) -> (p,), non-negative when satisfied.
    final_rows, final_weight, final_inequality : the same of the last state; (x, args) or (args).
    free : (stage, args) -> (b,) or (), 1 where a control may move and 0 where it is held.
    limits : (stage, args) -> lower and upper limits of the controls, (b,) or (); read by
        `interior_point` only, for the other solvers they belong among the inequalities.
    free_start : number of coordinates, the last ones of the error state, that are decided with the
        controls and stay the same, such as the length of a stage; for `interior_point`.
    linearisation : (x, u, x_next, stage, args) -> `Linearisation`, exact; lagrangian_hessian : (x,
        u, x_next, stage, args, costate) -> (n + b, n + b), Hessian of cost + costate . gap, exact
        or nearly so; both for `interior_point`, None to differentiate cost and dynamics.
    linearise : (x, u, x_next, stage, args) -> (n, n + b), derivatives of the next error state with
        respect to error state and controls; exact or nearly so, None to differentiate `dynamics`.
    """

    start: Callable[[Any], Array]
    stages: Callable[[Any], Any]
    dynamics: Callable[[Array, Array, Any, Any], Array]
    cost: Callable[[Array, Array, Any, Any, Array], Array]
    curvature: Callable[[Array, Array, Any, Any, Array], Array]
    error_size: int
    retract: Callable[[Array, Array], Array] = _plus
    difference: Callable[[Array, Array], Array] = _minus
    equality: Callable[[Array, Array, Any, Any], Array] = _no_rows
    equality_weight: Callable[[Any, Any], Array] = _hard
    inequality: Callable[[Array, Array, Any, Any], Array] = _no_rows
    final_rows: Callable[[Array, Any], Array] = _no_final_rows
    final_weight: Callable[[Any], Array] = _hard_at_the_end
    final_inequality: Callable[[Array, Any], Array] = _no_final_rows
    free: Callable[[Any, Any], Array] = _all_free
    limits: Callable[[Any, Any], tuple[Array, Array]] = _no_limits
    free_start: int = 0
    linearisation: Callable[[Array, Array, Array, Any, Any], Linearisation] | None = None
    lagrangian_hessian: Callable[[Array, Array, Array, Any, Any, Array], Array] | None = None
    linearise: Callable[[Array, Array, Array, Any, Any], Array] | None = None

    def derivatives(self, x: Array, u: Array, x_next: Array, stage: Any, args: Any) -> Array:
        """Derivatives of the next error state, (n, n + b); see `linearise`."""
        if self.linearise is not None:
            return self.linearise(x, u, x_next, stage, args)
        return exact_derivatives(self, x, u, x_next, stage, args)


def exact_derivatives(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Array:
    """As `OptimalControlProgram.derivatives`, by differentiating the dynamics, (n, n + b)."""
    n = program.error_size

    def move(z: Array) -> Array:
        x_moved = program.dynamics(program.retract(x, z[:n]), u + z[n:], stage, args)
        return program.difference(x_moved, x_next)

    return jnp.asarray(jax.jacfwd(move)(jnp.zeros(n + u.shape[0], x.dtype)))


def _moved(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Callable[[Array], tuple[Array, Array]]:
    """z -> gap (n,) and cost () of a stage."""
    n = program.error_size

    def at(z: Array) -> tuple[Array, Array]:
        x_moved, u_moved = program.retract(x, z[:n]), u + z[n:]
        gap = program.difference(program.dynamics(x_moved, u_moved, stage, args), x_next)
        return gap, program.cost(x_moved, u_moved, stage, args, jnp.zeros((), x.dtype))

    return at


def linearisation(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Linearisation:
    """A stage to first order; differentiated where the programme has nothing of its own."""
    if program.linearisation is not None:
        return program.linearisation(x, u, x_next, stage, args)
    moved = _moved(program, x, u, x_next, stage, args)
    at = jnp.zeros(program.error_size + u.shape[0], x.dtype)
    (dynamics, cost), (gap, _) = jax.jacfwd(lambda z: (moved(z), moved(z)), has_aux=True)(at)
    return Linearisation(gap, dynamics, cost)


def lagrangian_hessian(
    program: OptimalControlProgram,
    x: Array,
    u: Array,
    x_next: Array,
    stage: Any,
    args: Any,
    costate: Array,
) -> Array:
    """Hessian of cost + costate . gap of a stage, (n + b, n + b)."""
    if program.lagrangian_hessian is not None:
        return program.lagrangian_hessian(x, u, x_next, stage, args, costate)
    moved = _moved(program, x, u, x_next, stage, args)

    def lagrangian(z: Array) -> Array:
        gap, cost = moved(z)
        return cost + jnp.sum(costate * gap)

    hessian = jax.hessian(lagrangian)(jnp.zeros(program.error_size + u.shape[0], x.dtype))
    return jnp.asarray(0.5 * (hessian + hessian.T))


def least_squares(
    residual: Callable[[Array, Array, Any, Any], Array],
    error_size: int,
    retract: Callable[[Array, Array], Array] = _plus,
) -> tuple[Callable[..., Array], Callable[..., Array]]:
    """Cost |residual|^2 / 2 of a stage and its Gauss-Newton curvature, for a
    `OptimalControlProgram`.

    residual : (x, u, stage, args) -> (r,).  error_size, retract : those of the programme.
    """
    n = error_size

    def cost(x: Array, u: Array, stage: Any, args: Any, smoothing: Array) -> Array:
        return 0.5 * jnp.sum(residual(x, u, stage, args) ** 2)

    def curvature(x: Array, u: Array, stage: Any, args: Any, smoothing: Array) -> Array:
        def moved(z: Array) -> Array:
            return residual(retract(x, z[:n]), u + z[n:], stage, args)

        rows = jax.jacfwd(moved)(jnp.zeros(n + u.shape[0], x.dtype))
        return jnp.asarray(rows.T @ rows)

    return cost, curvature


def fly(program: OptimalControlProgram, u: Array, args: Any) -> tuple[Array, Array]:
    """States at nodes 0 to N - 1, (N, s), and at node N, (s,), under the controls u (N, b)."""

    def advance(x: Array, inputs: tuple[Array, Any]) -> tuple[Array, Array]:
        row, stage = inputs
        return program.dynamics(x, row, stage, args), x

    end, nodes = lax.scan(advance, program.start(args), (u, program.stages(args)))
    return nodes, end
