"""First-order conditions of a small programme without structure, as `jaxatt.minimize` solves it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.flatten_util import ravel_pytree

from jaxatt.optimize.dense.constraints import Box
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.sensitivity.conditions import Condensed, Conditions
from jaxatt.optimize.sensitivity.elimination import factored, solved


class DenseArguments(NamedTuple):
    """What an answer depends on.  args : of the functions.  box : bounds on the variables."""

    args: Any
    box: Box


class DensePoint(NamedTuple):
    """Variables x (n,) and multipliers: equality (m,), limits."""

    x: Array
    equality: Array
    limits: DenseLimits


class DenseLimits(NamedTuple):
    """One array for every kind of limit: inequality (p,), lower (n,), upper (n,)."""

    inequality: Array
    lower: Array
    upper: Array


class DenseSystem(NamedTuple):
    """Derivatives at a point.

    hessian : (n, n), of the Lagrangian.  slope : (n,), of the objective.  equality : (m, n) and
    inequality : (p, n), of the constraints.  rows : (m,), equalities.  margins : of all limits.
    """

    hessian: Array
    slope: Array
    equality: Array
    inequality: Array
    rows: Array
    margins: DenseLimits


@dataclass(frozen=True)
class DenseConditions(Conditions):
    """Conditions of an objective under equalities, inequalities and bounds.

    names : of the inequalities, then of the lower and the upper bounds; numbers of those that it
    leaves out.
    """

    functions: Functions
    names: tuple[str, ...] = ()

    def lagrangian(
        self, point: DensePoint, step: DensePoint, args: DenseArguments, active: DenseLimits
    ) -> Array:
        x = point.x + step.x
        objective, equality, inequality = self.functions.parts(x, args.args)
        total = objective + jnp.sum((point.equality + step.equality) * equality)
        return total - held_by(
            active,
            jax.tree.map(jnp.add, point.limits, step.limits),
            DenseLimits(inequality, *_within(x, args.box)),
        )

    def objective(self, point: DensePoint, args: DenseArguments) -> Array:
        return self.functions.parts(point.x, args.args)[0]

    def margins(self, point: DensePoint, args: DenseArguments) -> DenseLimits:
        _, _, inequality = self.functions.parts(point.x, args.args)
        return DenseLimits(inequality, *_within(point.x, args.box))

    def pinned(self, point: DensePoint, args: DenseArguments) -> DenseLimits:
        none = jnp.zeros(point.limits.inequality.shape, bool)
        held = args.box.lower == args.box.upper
        return DenseLimits(none, held, jnp.zeros_like(held))

    def multipliers(self, point: DensePoint) -> DenseLimits:
        return point.limits

    def released(self, point: DensePoint, active: DenseLimits) -> DensePoint:
        limits = jax.tree.map(lambda a, z: jnp.where(a, z, 0.0), active, point.limits)
        return point._replace(limits=limits)

    def zero(self, point: DensePoint) -> DensePoint:
        return jax.tree.map(jnp.zeros_like, point)

    def moved(self, point: DensePoint, step: DensePoint) -> DensePoint:
        return jax.tree.map(jnp.add, point, step)

    def system(self, point: DensePoint, args: DenseArguments) -> DenseSystem:
        weights = jnp.concatenate([jnp.ones(1), point.equality, -point.limits.inequality])
        rows, slopes = self.functions.derivatives(point.x, args.args)
        m = len(point.equality)
        return DenseSystem(
            self.functions.hessian(point.x, args.args, weights),
            slopes[0],
            slopes[1 : 1 + m],
            slopes[1 + m :],
            rows[1 : 1 + m],
            DenseLimits(rows[1 + m :], *_within(point.x, args.box)),
        )

    def residual(self, system: DenseSystem, point: DensePoint, active: DenseLimits) -> DensePoint:
        held = jax.tree.map(lambda a, z: jnp.where(a, z, 0.0), active, point.limits)
        by_x = system.slope + system.equality.T @ point.equality
        by_x = by_x - system.inequality.T @ held.inequality - held.lower + held.upper
        limits = jax.tree.map(
            lambda a, margin, z: jnp.where(a, -margin, -z), active, system.margins, point.limits
        )
        return DensePoint(by_x, system.rows, limits)

    def solve(self, system: DenseSystem, active: DenseLimits, right: DensePoint) -> DensePoint:
        n = system.slope.shape[0]
        eye = jnp.eye(n, dtype=system.slope.dtype)
        flags = jnp.concatenate(active)
        held = jnp.where(flags[:, None], -jnp.concatenate([system.inequality, eye, -eye]), 0.0)
        rows = jnp.concatenate([system.equality, held])
        m = system.equality.shape[0]
        corner = jnp.diag(jnp.concatenate([jnp.zeros(m), jnp.where(flags, 0.0, -1.0)]))
        matrix = jnp.block([[system.hessian, rows.T], [rows, corner]])
        whole, unflat = ravel_pytree(right)
        return unflat(solved(factored(matrix), whole))

    def condensed(self, system: DenseSystem, point: DensePoint) -> Condensed:
        eye = np.eye(len(point.x))
        return Condensed(
            np.asarray(system.hessian),
            np.asarray(system.equality),
            np.concatenate([np.asarray(system.inequality), eye, -eye]),
        )

    def labels(self, point: DensePoint) -> tuple[str, ...]:
        rows = [f"inequality {i}" for i in range(len(point.limits.inequality))]
        for side in ("lower", "upper"):
            rows += [f"{side} bound of x[{i}]" for i in range(len(point.x))]
        return (*self.names, *rows[len(self.names) :])


def _within(x: Array, box: Box) -> tuple[Array, Array]:
    """Margins (n,) to the lower and upper bounds; those that are equal count as one, the lower."""
    return x - box.lower, jnp.where(box.lower == box.upper, jnp.inf, box.upper - x)


def held_by(active: Any, multipliers: Any, margins: Any) -> Array:
    """What limits add to L, (): multipliers . margins where active, multipliers^2 / 2 elsewhere."""

    def of(holds: Array, multiplier: Array, margin: Array) -> Array:
        margin = jnp.where(holds, margin, 0.0)  # which may be infinite
        return jnp.sum(jnp.where(holds, multiplier * margin, 0.5 * multiplier**2))

    return sum(jax.tree.leaves(jax.tree.map(of, active, multipliers, margins)), jnp.zeros(()))
