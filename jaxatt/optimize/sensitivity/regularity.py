"""Whether an answer is regular, so that it moves smoothly with its parameters.

Source: Nocedal and Wright (2006), "Numerical Optimization", definitions 12.4, 12.5 and theorem
12.6; Robinson (1980), "Strongly regular generalized equations", for the strong second-order
condition.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import scipy

from jaxatt.optimize.sensitivity.conditions import Condensed
from jaxatt.runtime.arrays import Flags, Floats

_WEAK = 1e-6
"""Multiplier, as a share of the largest, and margin up to which a limit holds without force."""
_DEPENDENT = 1e-8
"""Singular value of the unit gradients of active limits below which they are dependent."""
_FLAT = 1e-7
"""Curvature, in units of each variable in which its own is one, up to which an answer is not a
strict minimum."""
_STRAIGHT = 1e-12
"""Curvature of a variable, as a share of the largest, up to which it counts as none of its own."""
_VANISHING = (1e-6, 1e-2)
"""Length of a gradient, as a share of the longest, up to which it has none: where Newton steps
converged, and where they did not, as they do not where it vanishes at the answer."""
_ROUGH = 1e-9
"""Residual, relative to the largest multiplier, up to which the conditions hold."""
_USUAL_PASSES = 9
"""Newton steps after which convergence cannot have been quadratic."""
_NAMED = 4


class Degeneracy(StrEnum):
    """Kinds of answers that do not move smoothly with all parameters."""

    NOT_STATIONARY = "not stationary"
    WEAK_LIMIT = "weakly active limit"
    DEPENDENT_LIMITS = "dependent active limits"
    FLAT = "no strict second-order condition"


@dataclass(frozen=True)
class Flag:
    """What is not regular about an answer.  sentence : says which limits, and what follows."""

    kind: Degeneracy
    sentence: str


@dataclass(frozen=True)
class Holding:
    """Limits of an answer on the host, flat.

    active : (p,), taken to hold.  margins, multipliers : (p,).  pinned : (p,), equations.
    residual : of the first-order conditions.  passes : Newton steps it took to get there.
    """

    active: Flags
    margins: Floats
    multipliers: Floats
    pinned: Flags
    residual: float
    passes: int

    @property
    def scale(self) -> float:
        """Size of the multipliers, at least one where there are none."""
        return float(np.abs(self.multipliers).max(initial=0.0)) or 1.0

    @property
    def weak(self) -> Flags:
        """Limits that are reached without force, (p,)."""
        idle = np.where(self.active, self.multipliers / self.scale, self.margins) <= _WEAK
        return idle & ~self.pinned


def flags_of(at: Condensed, holding: Holding, labels: tuple[str, ...]) -> tuple[Flag, ...]:
    """Everything that is not regular about an answer."""
    found = []
    rough = not holding.residual <= _ROUGH * max(1.0, holding.scale)
    if rough:
        found.append(
            Flag(
                Degeneracy.NOT_STATIONARY,
                f"Newton steps left a residual of {holding.residual:.2g} in the first-order "
                "conditions: the matrix is singular or the answer has not converged; the "
                "derivatives cannot be relied on",
            )
        )
    if holding.weak.any():
        found.append(
            Flag(
                Degeneracy.WEAK_LIMIT,
                f"{_named(holding.weak, labels)}: reached without force, so the answer has "
                "different derivatives to either side",
            )
        )
    rows = np.concatenate([at.equality, at.margins[holding.active | holding.weak]])
    rank, null = _null_space(rows, _VANISHING[rough])
    slow = holding.passes > _USUAL_PASSES
    if rank < len(rows) or (slow and not null.shape[1]):
        count = f", of rank {rank}," if rank < len(rows) else ""
        found.append(
            Flag(
                Degeneracy.DEPENDENT_LIMITS,
                f"{_named(holding.active, labels) or 'equations'}: the gradients of the "
                f"{len(rows)} equations and limits that hold{count} vanish or depend on each other "
                "(LICQ fails), so the multipliers are not unique",
            )
        )
    if holding.weak.any():
        strong = holding.active & ~holding.weak
        null = _null_space(np.concatenate([at.equality, at.margins[strong]]), _VANISHING[rough])[1]
    flat = _flat(at.hessian, null, holding.scale)
    if flat is not None or (slow and null.shape[1]):
        least = "0" if flat is None else f"{flat:.1g}"
        found.append(
            Flag(
                Degeneracy.FLAT,
                f"the curvature along what the limits leave free is as low as {least} of that of "
                "single variables: the answer is no strict minimum, and may move faster than its "
                "parameters",
            )
        )
    return tuple(found)


def _named(which: Flags, labels: tuple[str, ...]) -> str:
    names = [labels[i] for i in np.flatnonzero(which)]
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _null_space(rows: Floats, vanishing: float) -> tuple[int, Floats]:
    """Rank of rows (m, n), and a basis (n, n - rank) of what they leave free."""
    n = rows.shape[1]
    length = np.linalg.norm(rows, axis=1)
    there = length > vanishing * length.max(initial=0.0)
    usable = rows[there] / length[there, None]
    if not len(rows):
        return 0, np.eye(n)
    if not np.isfinite(usable).all():
        return 0, np.eye(n)
    _, values, vectors = np.linalg.svd(usable, full_matrices=True)
    rank = int((values > _DEPENDENT).sum())
    return rank, vectors[rank:].T


def _flat(hessian: Floats, null: Floats, scale: float) -> float | None:
    """The least curvature on a subspace (n, n - rank), where it is not clearly positive.

    It is that in units of each variable in which its own curvature is one: those of a time and of
    a torque may be apart by many powers of ten.
    """
    if not null.shape[1] or not np.isfinite(hessian).all():
        return None if not null.shape[1] else float("nan")
    reduced = null.T @ hessian @ null
    largest = max(float(np.abs(hessian).max(initial=0.0)), 1e-3 * scale)
    own = np.maximum(np.abs(np.diag(hessian)), _STRAIGHT * largest)
    squares = null.T @ (own[:, None] * null)
    least = scipy.linalg.eigh(
        0.5 * (reduced + reduced.T), squares, eigvals_only=True, subset_by_index=(0, 0)
    )
    return float(least[0]) if least[0] <= _FLAT else None
