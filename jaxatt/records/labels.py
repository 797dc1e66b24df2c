"""Arrays with the names of their axes, a unit and a description, as archives hold them."""

from __future__ import annotations

from typing import Any

import numpy as np

Variable = tuple[tuple[str, ...], Any, dict[str, Any]]
"""Names of the axes, values, attributes: what xarray takes for a variable."""

Label = tuple[tuple[str, ...], str, str]
"""Names of the axes, unit, words."""


def labelled(values: Any, dims: tuple[str, ...], units: str, words: str) -> Variable:
    """Make a variable of an archive; units : empty where there is none."""
    return dims, np.asarray(values), {"long_name": words} | ({"units": units} if units else {})
