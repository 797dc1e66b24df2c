"""Statuses of a solve, with their meaning and a remedy."""

from __future__ import annotations

from enum import IntEnum

RUNNING = -1
"""In place of a status, of a start that has not ended."""


class Status(IntEnum):
    """Status of one start.

    No start is CONVERGED unless violation and scaled stationarity were both below tolerance at
    the point that is returned.
    """

    CONVERGED = 0
    FEASIBLE = 1
    INFEASIBLE = 2
    ITERATION_LIMIT = 3
    NOT_FINITE = 4
    UNBOUNDED = 5

    @property
    def meaning(self) -> str:
        """Sentence that explains the status."""
        return _MEANING[self][0]

    @property
    def remedy(self) -> str:
        """Sentence on what usually helps."""
        return _MEANING[self][1]


_MEANING = {
    Status.CONVERGED: ("met constraints and stationarity to tolerance", "nothing to mend"),
    Status.FEASIBLE: (
        "met the constraints, but the point is not stationary to tolerance",
        "allow more iterations, or loosen the tolerance",
    ),
    Status.INFEASIBLE: (
        "stopped where the constraint violation no longer shrank",
        "try other starts, a longer horizon or larger limits",
    ),
    Status.ITERATION_LIMIT: (
        "reached its iteration limit before the constraints held",
        "allow more iterations, or try other starts",
    ),
    Status.NOT_FINITE: (
        "met a value or derivative that is not finite",
        "check the problem's data and the start",
    ),
    Status.UNBOUNDED: (
        "met the constraints while the objective fell without limit",
        "add the bound or constraint that keeps the objective finite",
    ),
}
