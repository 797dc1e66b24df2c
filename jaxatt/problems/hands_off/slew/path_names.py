"""Names of the path constraints of a slew, for messages."""

from __future__ import annotations

from collections.abc import Sequence

from jaxatt.problems.hands_off.slew.model import SlewForm
from jaxatt.problems.pointing.case import Pointing


def path_names(
    form: SlewForm, pointing: Pointing, wheels: Sequence[str], intervals: int
) -> tuple[str, ...]:
    """Names of `path_margins`, in its order; wheels : their names."""
    nodes = range(1, intervals + 1)
    names = []
    if form.speed_limited:
        names += [
            f"{side} speed limit of {wheel}, node {k}"
            for side in ("upper", "lower")
            for k in nodes
            for wheel in wheels
        ]
    if form.pointed:
        rows = [cone.name for cone in pointing.cones]
        rows += ["no cone"] * form.spare_cones(len(rows))
        if pointing.rate_limit is not None:
            rows += [
                f"{side} limit of rate {axis}" for side in ("upper", "lower") for axis in "xyz"
            ]
        names += [f"{row}, node {k}" for k in nodes for row in rows]
    return tuple(names)
