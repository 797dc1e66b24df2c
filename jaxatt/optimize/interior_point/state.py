"""State of the interior-point method between iterations; see `interior_point`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded, Nodes, limits_along
from jaxatt.optimize.optimal_control import OptimalControlProgram

RUNNING = -1
"""The status of a start that has not ended."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Shifts:
    """Regularisation of the Hessian where a model is not convex or a step is rejected.

    first : of a row of rejected passes.  growth : from one to the next.  shrink : after an accepted
    pass; a shift below `least` then becomes 0.  begin : of the first pass.
    """

    first: float
    growth: float
    shrink: float
    least: float
    begin: float = 0.0


LARGE_SHIFTS = Shifts(1e-4, 4.0, 1.5, 3.0 * 1e-4)
"""For controls that are pushed to their limits, where little depends on the curvature."""
SMALL_SHIFTS = Shifts(1e-5, 6.0, 2.0, 2e-7)
"""For nearly singular problems, which need a little of it nearly all the time."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class InteriorSettings:
    """Settings; all but the last three are traced.

    tolerance : of violation, scaled stationarity and complementarity.
    barrier : the first one.  factor, power : a solved barrier b becomes min(factor b, b^power).
    row_penalty : of the hard rows, and of active limits in the crossover.
    crossover_from : barrier from which the crossover may be tried; 0 for never.
    max_iterations : passes.  shifts : of the curvature.
    renewals : times that a start that is stuck goes on from where it is with new multipliers and
        slacks; with any, violated inequalities begin with slacks as large as what they miss.
    own_costates : whether the multipliers of the dynamics are variables of their own, as those of
        the other rows are, rather than found from those by the adjoint recursion.  Over hundreds of
        stages the recursion adds up what the other multipliers are still off by.
    settling : last passes of a start that has not converged, in which the regularisation grows, so
        that steps shrink and the constraints are met at least.
    """

    tolerance: float = 1e-8
    barrier: float = 0.02
    factor: float = 0.1
    power: float = 1.5
    row_penalty: float = 1e7
    crossover_from: float = 1e-3
    max_iterations: int = 200
    shifts: Shifts = LARGE_SHIFTS
    renewals: int = field(default=0, metadata={"static": True})
    own_costates: bool = field(default=False, metadata={"static": True})
    settling: int = field(default=0, metadata={"static": True})


class Point(NamedTuple):
    """Primal and dual variables.

    path, final : values that the inequalities are to take.  The others are multipliers; costates :
    (N, n), of the dynamics, without rows where they are not variables of their own.
    """

    nodes: Nodes
    path: Array
    final: Array
    dual: Bounded
    rows: Array
    equality: Array
    costates: Array


class Place(NamedTuple):
    """A point with its cost () and constraint violation ()."""

    point: Point
    cost: Array
    unmet: Array


class Crossover(NamedTuple):
    """State of the active-set crossover.

    left : () passes that it may still take, 0 where it is not under way.  active : limits that are
    taken to hold.  anchor : where it began, to which a start that fails in it goes back.
    below : () barrier from which it may be tried next.
    """

    left: Array
    active: Bounded
    anchor: Place
    below: Array


class State(NamedTuple):
    """State of a start between two iterations.

    barrier, shift : ().  most : () of `unmet` that a trial may have.  status : () a `Status` or
    `RUNNING`.  renewals : () left.  violation, stationarity : () at the point before.
    """

    place: Place
    crossover: Crossover
    barrier: Array
    shift: Array
    most: Array
    status: Array
    iterations: Array
    renewals: Array
    violation: Array
    stationarity: Array


class Limits(NamedTuple):
    """Limits of the controls, (N, b).

    below, above : whether there is one.  low, high : 0 without.
    """

    below: Array
    above: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, program: OptimalControlProgram, size: int, args: Any) -> Limits:
        """Limits of a programme's controls, `size` of them an interval."""
        lower, upper = limits_along(program, size, args)
        below, above = jnp.isfinite(lower), jnp.isfinite(upper)
        return cls(below, above, jnp.where(below, lower, 0.0), jnp.where(above, upper, 0.0))

    def slacks(self, point: Point) -> Bounded:
        """Slack of every limit; 1 where there is none."""
        u = point.nodes.u
        return Bounded(
            point.path,
            point.final,
            jnp.where(self.below, u - self.low, 1.0),
            jnp.where(self.above, self.high - u, 1.0),
        )

    def within(self, point: Point) -> Point:
        """The point with controls clipped to their limits and slacks that are not negative."""
        u = point.nodes.u
        u = jnp.where(self.below, jnp.maximum(u, self.low), u)
        u = jnp.where(self.above, jnp.minimum(u, self.high), u)
        return point._replace(
            nodes=point.nodes._replace(u=u),
            path=jnp.maximum(point.path, 0.0),
            final=jnp.maximum(point.final, 0.0),
        )

    def only_there(self, of: Bounded) -> Bounded:
        """Set the entries of infinite limits to zero."""
        return of._replace(
            lower=jnp.where(self.below, of.lower, 0.0), upper=jnp.where(self.above, of.upper, 0.0)
        )
