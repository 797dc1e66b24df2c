"""How a solve ended, in words, and what to do about it."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Outcome of one start.

    No start is CONVERGED unless violation and scaled stationarity were both below tolerance at
    the point that is returned.
    """

    CONVERGED = 0
    FEASIBLE = 1
    INFEASIBLE = 2
    ITERATION_LIMIT = 3
    NOT_FINITE = 4

    @property
    def meaning(self) -> str:
        """One sentence on the outcome."""
        return _MEANING[self][0]

    @property
    def remedy(self) -> str:
        """What usually helps."""
        return _MEANING[self][1]


_MEANING = {
    Status.CONVERGED: ("constraints and stationarity hold to tolerance", "nothing to mend"),
    Status.FEASIBLE: (
        "the constraints hold, but the point is not stationary to tolerance",
        "allow more iterations, or loosen the tolerance",
    ),
    Status.INFEASIBLE: (
        "stopped at a point where the constraint violation cannot be reduced locally",
        "try other starts, a longer horizon or larger limits",
    ),
    Status.ITERATION_LIMIT: (
        "the iteration limit came before the constraints held",
        "allow more iterations, or try other starts",
    ),
    Status.NOT_FINITE: (
        "a value or derivative was not finite",
        "check the problem's data and the start",
    ),
}
