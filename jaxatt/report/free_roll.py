"""The roll that was found where a target leaves it free."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jaxatt.attitude.free_roll import nearest_roll, roll_angle
from jaxatt.records.phase import Phase
from jaxatt.records.wording import short

FREE_ROLL = "boresight"
"""Name of the body axis in `Phase.reference`."""


def free_roll(phase: Phase) -> dict[str, Any] | None:
    """The roll of a phase at its end, and the attitude reached; None where it was not free.

    The attitude is `q_ob` or, where net power is maximised, `q_ib`, as in the archive of a result.
    The roll counts about the boresight from the attitude that points the same way by the shortest
    turn from where the phase began.
    """
    if FREE_ROLL not in phase.reference:
        return None
    name = "q_ob" if "q_ob" in phase.reference else "q_ib"
    axis, q = phase.reference[FREE_ROLL], np.asarray(phase.series[name])
    reached = q[len(phase.active)]
    nearest = nearest_roll(phase.reference[name], axis, q[0])
    return {
        "body_axis": axis.tolist(),
        "roll_deg": math.degrees(float(roll_angle(nearest, axis, reached))),
        name: reached.tolist(),
    }


def roll_words(found: dict[str, Any] | None) -> str:
    """The roll and the attitude in one line; empty where the roll was not free."""
    if found is None:
        return ""
    name = "q_ob" if "q_ob" in found else "q_ib"
    q = ", ".join(short(part, 5) for part in found[name])
    return f"{short(found['roll_deg'], 5)} deg, {name} = ({q})"
