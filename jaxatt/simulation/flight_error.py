"""How wrong a flight can be: it is flown again with more steps, until two flights agree.

The finer flight runs the same compiled program: every interval is cut into equal parts, and the
flight into as many pieces, each of which has as many parts as the flight had intervals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.flight import MINIMUM_SUBSTEPS, Trajectory, at_nodes
from jaxatt.simulation.step_error import States, each_apart, states_apart
from jaxatt.spacecraft.dynamics import AttitudeState

AGREE = 0.1
"""Of the tolerances at the end, what two flights may differ by."""
_MOST = 64
"""Times as many steps as the first flight, at most."""
_MOST_OF_MANY = 16
"""The same where many answers are flown side by side: each number of steps is compiled anew."""
_FINER = 2
"""Times the steps that a search needs, at least, in flights that judge its answers."""


@dataclass(frozen=True)
class FlightError:
    """Largest difference between the two finest flights of one answer, at any node.

    attitude : [rad].  rate : [rad/s].  steps : Runge-Kutta steps an interval of the finest, which
    is the one that is judged and has a sixteenth of that error.  agreed : whether the difference is
    below a tenth of the tolerances; no answer counts as reached where it is not.
    """

    attitude: float
    rate: float
    steps: int
    agreed: bool

    @property
    def named(self) -> dict[str, float]:
        """The differences under the names of errors: "attitude" [rad] and "rate" [rad/s]."""
        return {"attitude": self.attitude, "rate": self.rate}


def judging_steps(needed: int) -> int:
    """Runge-Kutta steps an interval of flights that judge, for a search that needs so many.

    Doubled as often as it takes, so that there are few compiled programs.
    """
    times = _FINER * needed / MINIMUM_SUBSTEPS
    return MINIMUM_SUBSTEPS << max(0, math.ceil(math.log2(times)))


def fly_until_agreed(
    fly: Callable[[int], Trajectory], steps: int, tolerances: Mapping[str, float], end: int
) -> tuple[Trajectory, FlightError]:
    """Fly one answer with twice as many steps, until that changes it by less than a tenth of the
    tolerances.

    fly : from how many times as many steps to the flight, (1, nodes, ...).  steps : Runge-Kutta
    steps an interval of `fly(1)`.  tolerances : "attitude" [rad] and "rate" [rad/s].
    end : the last node that counts.

    Returns the finest flight, and what it differs by from the one before.
    """
    times, coarse = 1, fly(1)
    while True:
        times *= 2
        fine = fly(times)
        error = between(_until(coarse, end), _until(fine, end), times * steps, tolerances)
        if error.agreed or times >= _MOST:
            return fine, error
        coarse = fine


@dataclass(frozen=True, eq=False)
class FlightErrors:
    """As `FlightError`, of S answers: attitude [rad], rate [rad/s], steps and agreed, each (S,)."""

    attitude: Floats
    rate: Floats
    steps: Floats
    agreed: Flags


def fly_all_until_agreed(
    fly: Callable[[npt.NDArray[np.int64], int], Trajectory],
    count: int,
    steps: int,
    tolerances: Mapping[str, float],
) -> tuple[Trajectory, FlightErrors]:
    """As `fly_until_agreed`, for many answers at once; those that agree are not flown again.

    fly : from answers and how many times as many steps to their flights, (S, nodes, ...).
    count : of the answers.
    """
    rows, times = np.arange(count), 1
    finest = jax.tree.map(np.array, fly(rows, times))
    unknown = np.full(count, np.inf)
    errors = FlightErrors(unknown, unknown.copy(), unknown.copy(), np.zeros(count, bool))
    while len(rows) and times < _MOST_OF_MANY:
        times *= 2
        fine = fly(rows, times)
        coarse = jax.tree.map(lambda leaf, at=rows: leaf[at], finest)
        pairs = ((np.asarray(x.q_ob), np.asarray(x.omega_ob)) for x in (coarse, fine))
        attitude, rate = (x.max(axis=1) for x in each_apart(*pairs))
        errors.attitude[rows], errors.rate[rows], errors.steps[rows] = attitude, rate, times * steps
        agreed = attitude <= AGREE * tolerances["attitude"]
        agreed &= rate <= AGREE * tolerances["rate"]
        errors.agreed[rows] = agreed
        for whole, part in zip(jax.tree.leaves(finest), jax.tree.leaves(fine), strict=True):
            whole[rows] = part
        rows = rows[~agreed]
    return finest, errors


def _until(flown: Trajectory, end: int) -> States:
    """Attitudes and rates of the first flight, up to a node."""
    return np.asarray(flown.q_ob)[0, : end + 1], np.asarray(flown.omega_ob)[0, : end + 1]


def between(
    coarse: States, fine: States, steps: int, tolerances: Mapping[str, float]
) -> FlightError:
    """Error of a flight from one with half as many steps.

    coarse, fine : attitudes (nodes, 4) and rates (nodes, 3) [rad/s].  steps : those of the finer.
    tolerances : "attitude" [rad] and "rate" [rad/s].
    """
    attitude, rate = states_apart(coarse, fine)
    agreed = attitude <= AGREE * tolerances["attitude"] and rate <= AGREE * tolerances["rate"]
    return FlightError(attitude, rate, steps, agreed)


def fly_in_pieces(
    fly: Callable[[AttitudeState, Any, int], Trajectory],
    start: AttitudeState,
    rows: Any,
    times: int,
) -> Trajectory:
    """Fly one answer with so many times as many steps, piece by piece.

    fly : (state, rows of this piece, number of the piece) -> its flight, (1, nodes, ...).
    rows : pytree that leads with the parts of all intervals, `times` as many as there are
    intervals.

    Returns the flight at the ends of the intervals.
    """
    count = len(jax.tree.leaves(rows)[0]) // times
    pieces = []
    for number in range(times):
        here = slice(number * count, (number + 1) * count)
        piece = fly(start, jax.tree.map(lambda leaf, k=here: leaf[k], rows), number)
        start = AttitudeState(*(np.asarray(x)[0, -1] for x in _state(piece)))
        pieces.append(piece)
    return at_nodes(_joined(pieces), times)


def _state(flown: Trajectory) -> tuple[Any, Any, Any]:
    return flown.q_ob, flown.omega_ib, flown.omega_bw


def _joined(pieces: list[Trajectory]) -> Trajectory:
    """Flights (1, nodes, ...) that begin where the one before ended, as one."""

    def nodes(name: str) -> Any:
        parts = [np.asarray(getattr(piece, name)) for piece in pieces]
        return np.concatenate([parts[0], *(part[:, 1:] for part in parts[1:])], axis=1)

    def held(name: str) -> Any:
        return np.concatenate([np.asarray(getattr(piece, name)) for piece in pieces], axis=1)

    at = {name: nodes(name) for name in ("q_ob", "omega_ob", "omega_bw", "omega_ib")}
    return Trajectory(**at, wheel_torque=held("wheel_torque"), thrust=held("thrust"))
