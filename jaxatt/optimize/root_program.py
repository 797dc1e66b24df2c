"""Programme of sparse root finding: rows that few controls are to bring to zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.equations import Equations, Linearise, from_response
from jaxatt.optimize.optimal_control import OptimalControlProgram


@dataclass(frozen=True)
class RootProgram:
    """A sparse root-finding problem as functions of u, (N, b), and `args`; None where absent.

    free : args -> (N, b), 1 where control is allowed.
    importance : args -> (N,), cost of an active stage.
    row_weight : args -> (m,), inf for rows that must vanish; w for rows that cost w/2 row^2.
    response : (u, args) -> rows (m,) and their derivatives (N, m, b), exact or nearly so.
    equations : (u, weights, moved, accurate, args) -> the same rows, linearised for a weighted
        step, beside `response` where that is cheaper.
    path : (u, args) -> (K,) and (N, K, b), rows that must not be negative, and their derivatives.
    stages : the same rows interval by interval; its cost is not used, and its inequalities leave
        the limits out.
    limits : args -> (l, b), rows with |l u[k]| <= 1 for every stage k.
    bounds : args -> lower and upper limits of each control, (b,) or (N, b).
    effort_map : args -> (q, b), the quantities whose magnitudes make up the effort.
    effort_scale : args -> () or (N,), what a unit of effort costs, in every stage.
    shared : whether a stage's controls count as one.
    """

    free: Callable[[Any], Array]
    importance: Callable[[Any], Array]
    row_weight: Callable[[Any], Array]
    response: Callable[[Array, Any], tuple[Array, Array]] | None = None
    equations: Callable[[Array, Array, Array, Array, Any], Equations] | None = None
    path: Callable[[Array, Any], tuple[Array, Array]] | None = None
    stages: OptimalControlProgram | None = None
    limits: Callable[[Any], Array] | None = None
    bounds: Callable[[Any], tuple[Array, Array]] | None = None
    effort_map: Callable[[Any], Array] | None = None
    effort_scale: Callable[[Any], Array] | None = None
    shared: bool = True

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support, those of the stages included."""
        asked = {
            features.ROWS_AT_ONCE: self.response is not None,
            features.ROWS_BY_STAGE: self.stages is not None,
            features.MAGNITUDE_LIMITS: self.limits is not None,
            features.SEPARATE_BOUNDS: self.bounds is not None,
            features.ONE_SIDED_ROWS: self.path is not None,
            features.COUNTED_APART: not self.shared,
            features.EFFORT: self.effort_map is not None and self.effort_scale is not None,
        }
        own = frozenset(name for name, there in asked.items() if there)
        return own if self.stages is None else own | self.stages.features

    def linearise(self, args: Any) -> Linearise:
        """Function that linearises the rows for weighted least-norm steps."""
        equations, response = self.equations, self.response
        if equations is not None:
            return lambda u, weights, moved, accurate: equations(u, weights, moved, accurate, args)
        assert response is not None
        return from_response(lambda u: response(u, args))
