"""Notes on cones that the search took stricter than they are."""

from __future__ import annotations

import math

from jaxatt.records.phase import Phase
from jaxatt.records.wording import limit_label


def constraint_margin_notes(phase: Phase) -> tuple[str, ...]:
    """Notes on the cones that the search took stricter than they are."""
    record = phase.pointing
    if record is None:
        return ()
    return tuple(
        f"{limit_label(extreme.kind, extreme.name)} was taken {math.degrees(margin):.2g} deg "
        "stricter, so that the way between the nodes keeps to it"
        for extreme, margin in zip(record.extremes, record.constraint_margin, strict=False)
        if margin > 0.0
    )
