"""Explanation of why an answer does not reach its target."""

from __future__ import annotations

from collections.abc import Sequence

from jaxatt.optimize.status import Status
from jaxatt.problems.verdict import Verdict
from jaxatt.records.pointing import PointingRecord
from jaxatt.records.wording import broken_limit, uncertain_flight
from jaxatt.simulation.flight_error import FlightError

_ERROR_WORDS = {
    "attitude": "the target attitude",
    "rate": "the target rate",
    "waypoint": "the waypoint's attitude",
    "wheel speed": "the wheels' speed at the end",
    "wheel bias": "the bias of the wheels at the end",
    "state": "the target state",
}


def failure_reason(
    verdict: Verdict,
    status: Status,
    pointing: PointingRecord | None = None,
    also: Sequence[str] = (),
    broken_margins: Sequence[str] = (),
    flight_error: FlightError | None = None,
) -> str:
    """Sentence on the constraints that an answer violates, and on how its solver ended.

    broken_margins : the path constraints that are violated, where they are known by name.
    also : what else is worth telling, before the solver's own ending.
    flight_error : of the flight that was judged.
    """
    missed = [
        f"{_ERROR_WORDS[name]} is missed by {error[0] / verdict.tolerances[name]:.3g} times its "
        "tolerance"
        for name, error in verdict.errors.items()
        if not error[0] <= verdict.tolerances[name]
    ]
    if not verdict.within_limits[0]:
        missed.append(f"a control limit is exceeded by {verdict.limit_violation[0]:.3g}")
    broken = [] if pointing is None else [e for e in pointing.extremes if not e.satisfied]
    missed += [broken_limit(extreme) for extreme in broken]
    missed += broken_margins
    named = broken or broken_margins
    if verdict.margin_violation[0] > Verdict.MARGIN_TOLERANCE and not named:
        missed.append(f"a path constraint is violated by {verdict.margin_violation[0]:.3g}")
    if flight_error is not None and not flight_error.agreed:
        missed.append(uncertain_flight(flight_error))
    missed += also
    if status not in (Status.CONVERGED, Status.FEASIBLE):
        missed.append(f"the solver {status.meaning}: {status.remedy}")
    return "; ".join(missed)
