"""Inner minimisers of the augmented Lagrangian, by name."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

from jaxatt.optimize.augmented_lagrangian.gauss_newton import gauss_newton

if TYPE_CHECKING:
    import optax

NAMES = ("gauss-newton", "lbfgs", "adam")
DENSE_NAMES = ("newton", "gauss-newton", "lbfgs", "adam")
"""Those of the dense solver, which has the exact Hessian."""


def _without_model(
    transformation: optax.GradientTransformationExtraArgs,
) -> optax.GradientTransformationExtraArgs:
    """Drop the argument `model`, which optax's own transformations do not know."""

    import optax

    def update(
        updates: Any, state: Any, params: Any = None, *, model: Any = None, **extra: Any
    ) -> tuple[Any, Any]:
        return transformation.update(updates, state, params, **extra)

    return optax.GradientTransformationExtraArgs(transformation.init, update)


@functools.cache
def inner_minimiser(name: str) -> optax.GradientTransformationExtraArgs:
    """Optax transformation that serves as inner minimiser of the augmented Lagrangian.

    "gauss-newton" uses the problem's structure and is the default; "lbfgs" and "adam" are optax's
    own, for comparison and for problems without structure.
    """
    import optax

    if name == "gauss-newton":
        return gauss_newton()
    if name == "lbfgs":
        search = optax.scale_by_backtracking_linesearch(max_backtracking_steps=15)
        return _without_model(optax.lbfgs(linesearch=search))
    if name == "adam":
        return _without_model(optax.with_extra_args_support(optax.adam(2e-2)))
    raise ValueError(f"inner = {name!r}: unknown; choose one of {', '.join(NAMES)}")
