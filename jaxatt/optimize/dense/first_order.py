"""First-order minimisers of optax inside the dense solver, for comparison and many variables."""

from __future__ import annotations

from typing import Any, ClassVar

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense import proposals
from jaxatt.optimize.dense.arrays import choose
from jaxatt.optimize.dense.constraints import Constraints


class FirstOrder:
    """Search directions by "lbfgs" or "adam", reset with every new augmented Lagrangian."""

    NAMES: ClassVar[tuple[str, ...]] = ("lbfgs", "adam")

    def __init__(self, name: str) -> None:
        import optax

        self._searches = name == "lbfgs"
        self._rule = optax.lbfgs(linesearch=None) if self._searches else optax.adam(1e-2)

    def init(self, x: Array) -> Any:
        """State before the first step."""
        return self._rule.init(x)

    def propose(
        self,
        x: Array,
        gradient: Array,
        fixed: Array,
        state: Any,
        fresh: Array,
        radius: Array,
        constraints: Constraints,
    ) -> tuple[Array, Any]:
        """Trial points (k, n) and the new state; fresh : () bool, drop the history."""
        state = choose(fresh, self._rule.init(x), state)
        free = jnp.where(fixed, 0.0, gradient)
        direction, state = self._rule.update(free, state, x)
        if not self._searches:
            return constraints.project(x + direction)[None], state
        return proposals.along(x, gradient, direction, fixed, radius, constraints), state
