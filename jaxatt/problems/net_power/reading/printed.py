"""What a source prints of manoeuvres and plans that earn energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jaxatt.problems.reading.fields import Table

PRINTED_ROWS = {
    "net_J": 1,
    "baseline_J": 1,
    "quaternion_error": 1,
    "rate_error": 1,
    "baseline_quaternion_error": 1,
    "baseline_rate_error": 1,
}
"""Numbers of each of the [[printed.rows]]."""

_TOTALS = ("totals_J", "baseline_totals_J")


def check_printed_totals(printed: Mapping[str, Any], origin: str) -> None:
    """Refuse totals that are no numbers, or not as many of the optimum as of the PD law."""
    if not any(key in printed for key in _TOTALS):
        return
    table = Table(dict(printed), origin, "[printed]", tuple(printed))
    first = table.require(_TOTALS[0])
    for key in _TOTALS:
        table.vector(key, len(first) if isinstance(first, list) else 1)
