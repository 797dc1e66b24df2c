"""Second-order model of a programme at a point, for an interior-point step.

The costates of the dynamics are those of the current multipliers, by the adjoint recursion: the
gradient of the Lagrangian by the states vanishes, and what is left by the controls and by the free
coordinates of the first state is how far the point is from being stationary.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.optimize.optimal_control import OptimalControlProgram, lagrangian_hessian, linearisation


class Nodes(NamedTuple):
    """States and controls of all nodes.

    x : (N, s), states at nodes 0 to N - 1.  end : (s,), state at node N.  u : (N, b).
    """

    x: Array
    end: Array
    u: Array

    @property
    def following(self) -> Array:
        """States at nodes 1 to N, (N, s)."""
        return jnp.concatenate([self.x[1:], self.end[None]])


class Bounded(NamedTuple):
    """One array for every kind of inequality, e.g. of slacks, multipliers or steps.

    path : (N, p).  final : (t,).  lower, upper : (N, b), of the controls.
    """

    path: Array
    final: Array
    lower: Array
    upper: Array


class Model(NamedTuple):
    """A programme to second order around a point; z is error state, then controls.

    gap : (N, n), of the dynamics.  dynamics : (N, n, z).
    gradient : (N, z) and hessian : (N, z, z), of the Lagrangian without the controls' limits.
    path : (N, p) and path_slope : (N, p, z).  equality : (N, q) and equality_slope : (N, q, z).
    rows : (r,), final_slope : (r, n).  final : (t,), final_path_slope : (t, n).
    final_hessian : (n, n).  costate : (n,), at the first node.
    costates : (N, n), at the others, by the adjoint recursion.
    """

    gap: Array
    dynamics: Array
    gradient: Array
    hessian: Array
    path: Array
    path_slope: Array
    equality: Array
    equality_slope: Array
    rows: Array
    rows_slope: Array
    final: Array
    final_slope: Array
    final_hessian: Array
    costate: Array
    costates: Array


def limits_along(program: OptimalControlProgram, size: int, args: Any) -> tuple[Array, Array]:
    """Lower and upper limits of the controls, (N, b)."""

    def at(stage: Any) -> tuple[Array, Array]:
        lower, upper = program.control_limits(stage, args)
        return jnp.broadcast_to(lower, (size,)), jnp.broadcast_to(upper, (size,))

    return jax.vmap(at)(program.stages(args))


class Duals(NamedTuple):
    """Multipliers of hard rows and inequalities.

    equality : (N, q).  rows : (r,).  path : (N, p).  final : (t,).
    """

    equality: Array
    rows: Array
    path: Array
    final: Array


def _bent(of: Callable[[Array], Array], at: Array) -> Array:
    """Second derivatives of a scalar, forward twice, each pair of directions once.

    Backwards, every entry that is read becomes an addition to a whole vector, and the compiler
    takes four times as long, and gigabytes, for a few rows.
    """
    size = at.shape[0]
    first, second = np.triu_indices(size)
    place = np.zeros((size, size), int)
    place[first, second] = place[second, first] = np.arange(len(first))
    ways = jnp.eye(size, dtype=at.dtype)

    def along(a: Array, b: Array) -> Array:
        return jax.jvp(lambda z: jax.jvp(of, (z,), (a,))[1], (at,), (b,))[1]

    return jax.vmap(along)(ways[first], ways[second])[place]


def model(
    program: OptimalControlProgram,
    nodes: Nodes,
    duals: Duals,
    args: Any,
    costates: Array | None = None,
) -> Model:
    """Compute the derivatives of all stages.

    costates : (N, n), multipliers of the dynamics in the Hessian; None for those of the adjoint
    recursion.
    """
    n, size = program.error_size, nodes.u.shape[1]
    dtype = nodes.u.dtype
    rest = jnp.zeros(n, dtype)

    def ended(error: Array) -> tuple[Array, Array]:
        x = program.retract(nodes.end, error)
        return program.final_equalities(x, args), program.final_inequalities(x, args)

    def last(error: Array) -> Array:
        hard, soft = ended(error)
        total = jnp.sum(duals.rows * hard) - jnp.sum(duals.final * soft)
        if program.terminal_cost is None:
            return total
        return total + program.terminal_cost(program.retract(nodes.end, error), args)

    values, slopes_at_end = ended(rest), jax.jacfwd(ended)(rest)

    at = jnp.zeros(n + size, dtype)

    def inequality(z: Array, x: Array, u: Array, stage: Any) -> Array:
        return program.inequalities(program.retract(x, z[:n]), u + z[n:], stage, args)

    def equality(z: Array, x: Array, u: Array, stage: Any) -> Array:
        return program.equalities(program.retract(x, z[:n]), u + z[n:], stage, args)

    def first(
        x: Array, x_next: Array, u: Array, held: Array, dual: Array, stage: Any
    ) -> tuple[Any, ...]:
        found = linearisation(program, x, u, x_next, stage, args)
        margins = inequality(at, x, u, stage) if found.path is None else found.path
        missed = equality(at, x, u, stage)
        slope = equality_slope = jnp.zeros((0, n + size), dtype)
        by_cost = found.cost
        if margins.shape[0]:
            known = found.path_slope
            slope = jax.jacfwd(inequality)(at, x, u, stage) if known is None else known
            by_cost = by_cost - jnp.sum(dual[:, None] * slope, axis=0)
        if missed.shape[0]:
            equality_slope = jax.jacfwd(equality)(at, x, u, stage)
            by_cost = by_cost + jnp.sum(held[:, None] * equality_slope, axis=0)
        return (
            found.gap,
            found.dynamics,
            by_cost,
            margins,
            slope,
            missed,
            equality_slope,
            found.kept,
        )

    def backwards(costate: Array, inputs: tuple[Array, Array]) -> tuple[Array, Any]:
        dynamics, by_cost = inputs
        gradient = by_cost + jnp.sum(dynamics * costate[:, None], axis=0)
        return gradient[:n], (gradient, costate)

    def second(
        x: Array,
        x_next: Array,
        u: Array,
        held: Array,
        dual: Array,
        costate: Array,
        kept: Any,
        stage: Any,
    ) -> Array:
        hessian = lagrangian_hessian(program, x, u, x_next, stage, args, costate, kept)
        if dual.shape[0] and program.path_hessian is not None:
            hessian = hessian - program.path_hessian(x, u, stage, args, dual, kept)
        elif dual.shape[0]:
            hessian = hessian - _bent(lambda z: jnp.sum(dual * inequality(z, x, u, stage)), at)
        if held.shape[0]:
            hessian = hessian + _bent(lambda z: jnp.sum(held * equality(z, x, u, stage)), at)
        return hessian

    # The recursion of the costates alone is a loop: inside it XLA would compute the rest again for
    # every use, and all stages at once are fewer and larger operations.
    stages, following = program.stages(args), nodes.following
    inputs = (nodes.x, following, nodes.u, duals.equality, duals.path)
    gap, dynamics, by_cost, *derived, kept = jax.vmap(first)(*inputs, stages)
    margins, slope, missed, equality_slope = derived
    costate, (gradient, adjoint) = lax.scan(
        backwards, jax.grad(last)(rest), (dynamics, by_cost), reverse=True
    )
    curving = adjoint if costates is None else costates
    hessian = jax.vmap(second)(*inputs, curving, kept, stages)
    return Model(
        gap,
        dynamics,
        gradient,
        hessian,
        margins,
        slope,
        missed,
        equality_slope,
        values[0],
        slopes_at_end[0],
        values[1],
        slopes_at_end[1],
        _bent(last, rest),
        costate,
        adjoint,
    )


class Values(NamedTuple):
    """Values that a line search needs.

    cost : ().  path : (N, p).  final : (t,).  unmet : () sum of the sizes of gaps and rows.
    """

    cost: Array
    path: Array
    final: Array
    unmet: Array


def values(program: OptimalControlProgram, nodes: Nodes, args: Any) -> Values:
    """Evaluate cost and constraints without derivatives, for the line search."""

    def at(x: Array, x_next: Array, u: Array, stage: Any) -> tuple[Array, Array, Array]:
        ahead, cost = program.next_and_cost(x, u, stage, args)
        missed = jnp.sum(jnp.abs(program.difference(ahead, x_next)))
        if program.equality is not None:
            missed = missed + jnp.sum(jnp.abs(program.equality(x, u, stage, args)))
        return cost, missed, program.inequalities(x, u, stage, args)

    cost, gaps, path = jax.vmap(at)(nodes.x, nodes.following, nodes.u, program.stages(args))
    rows = program.final_equalities(nodes.end, args)
    unmet = jnp.sum(gaps) + jnp.sum(jnp.abs(rows))
    total = jnp.sum(cost)
    if program.terminal_cost is not None:
        total = total + program.terminal_cost(nodes.end, args)
    return Values(total, path, program.final_inequalities(nodes.end, args), unmet)
