"""Check that the parameters of a problem are arrays of numbers."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np


def check_arrays(parameters: Any) -> None:
    """Raise ValueError for the first parameter that is not an array of real numbers."""
    leaves = jax.tree_util.tree_flatten_with_path(parameters, is_leaf=lambda x: x is None)[0]
    for path, leaf in leaves:
        try:
            kind = np.asarray(leaf).dtype.kind
        except (TypeError, ValueError):
            kind = "O"
        if kind not in "biuf":
            raise ValueError(
                f"parameters{jax.tree_util.keystr(path)} is {leaf!r}, of type "
                f"{type(leaf).__name__}; every parameter has to be an array of real numbers"
            )
