"""Reweighting: the weights and the schedule of steps that lead to few active controls.

Every step minimises sum |v|^2 / d with weights d that come from the last iterate: large where it is
large.  With d = |u|^2 + s^2 and s shrinking, that is iterative reweighting for the log-sum measure
of sparsity, and the support decides itself.  Then the support is frozen, and d = sqrt(u^2 + s^2)
leads to the least sum of magnitudes on it.

Sources: Candes, Wakin and Boyd (2008), "Enhancing sparsity by reweighted l1 minimization";
Chartrand and Yin (2008), "Iteratively reweighted algorithms for compressive sensing".
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

SUPPORT_THRESHOLD = 1e-3
"""Controls, in units of their scale, that count as active when the support is frozen."""

_CHEAPEST = 1e-9
"""Least cost of an active stage that is reckoned with: nothing is free of charge."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Gradual:
    """Settings of supports that are decided by small steps from the start's own controls.

    share : of a step, the most that is taken.  reach : most change of the controls in one, in units
    of what they sum to.  level : share of a limit from which more of a control makes it no cheaper,
    so that what must be large is spread over neighbours before a limit binds.
    """

    share: float = 0.2
    reach: float = 0.1
    level: float = 0.5


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Reweighting:
    """Settings; all are traced, so changing one does not recompile.

    deciding : steps in which the support decides itself; none if it is given.
    smoothing, factor : the first s of those and what it shrinks by in each.
    settling : steps on the frozen support.  settled_smoothing : their s.
    spreading : the first s on a given support, where it is larger; it spreads the torque evenly,
        which finds a way if any, and shrinks by the same factor.
    effort : what a unit of effort costs while settling, in units of the soft rows' cost.
    gradual : how supports are decided from starts that nearly satisfy rows that bend much; the
        first step begins without control where there is none.
    """

    deciding: int = 14
    smoothing: float = 0.1
    factor: float = 0.587
    settling: int = 2
    settled_smoothing: float = 1e-3
    spreading: float = 0.0
    effort: float = 1.0
    gradual: Gradual | None = None


class SparseRoot(NamedTuple):
    """Result of one start.

    u : (N, b).  support : (N, b), 1 where control was allowed in the end.
    residual : () largest violation of a hard row at the point before the last step.
    saturated : () whether a limit bound in the last step that the next one would have had to leave.
    moved : () largest change of a control in the last step; () where it is not known.
    """

    u: Array
    support: Array
    residual: Array
    saturated: Array
    moved: Any = ()


class Course(NamedTuple):
    """Progress of the reweighting of a start.

    made : () steps.  pattern : (N, b), controls that the first weights come from. support : (N, b),
    1 where control is allowed.
    """

    made: Array
    pattern: Array
    support: Array


class Weighted(NamedTuple):
    """Weights of a step.

    course : after this step.  weights : (N, b), d, zero off the support. deciding, freezing : ()
    whether the support decides itself, is frozen in this step.
    """

    course: Course
    weights: Array
    deciding: Array
    freezing: Array


def begin(settings: Reweighting, start: Array, free: Array) -> tuple[Course, Array]:
    """Course of a start (N, b), and the controls (N, b) before the first step.

    The pattern of the start is what makes it differ from another: the first weights come from it,
    but the first step begins at rest.  Where the support is given, or decided gradually, the start
    is the first controls.
    """
    if settings.gradual is not None:
        return Course(jnp.asarray(0), start, free), start * free
    first = jnp.where(settings.deciding > 0, 0.0, start * free)
    return Course(jnp.asarray(0), start, free), first


def total(values: Array) -> Array:
    """Sum over the columns of (N, b), elementwise, so that the batch axis stays in place."""
    return functools.reduce(operator.add, (values[:, c] for c in range(values.shape[1])))


def weigh(
    settings: Reweighting, course: Course, u: Array, importance: Array, shared: bool
) -> Weighted:
    """Compute the weights (N, b) of the next step from the last iterate.

    importance : (N,), cost of an active stage.  shared : whether its controls count as one.
    """
    i = course.made
    deciding = i < settings.deciding
    smoothing = settings.smoothing * settings.factor**i
    squared = jnp.where(i == 0, course.pattern, u) ** 2
    if shared:
        squared = jnp.broadcast_to(total(squared)[:, None], u.shape)
    freezing = (i == settings.deciding) & (i > 0)
    support = course.support * ((squared > SUPPORT_THRESHOLD**2) | ~freezing)
    counted = (squared + smoothing**2) * (0.5 * jnp.log1p(1.0 / smoothing**2))
    early = jnp.where(settings.deciding > 0, 0.0, settings.factor**i)
    least = jnp.maximum(settings.settled_smoothing, settings.spreading * early)
    spent = jnp.sqrt(u**2 + least**2) / settings.effort
    price = jnp.maximum(importance, _CHEAPEST)[:, None]
    weights = support * jnp.where(deciding, counted / price, spent)
    return Weighted(Course(i + 1, course.pattern, support), weights, deciding, freezing)


def done(settings: Reweighting, course: Course) -> Array:
    """Whether all steps have been made, ()."""
    return course.made >= settings.deciding + settings.settling
