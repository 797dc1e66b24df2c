"""Coordinates of the wheels in an archive."""

from __future__ import annotations

from jaxatt.records.labels import Variable
from jaxatt.spacecraft.wheels import ReactionWheels


def wheel_coordinates(wheels: ReactionWheels) -> dict[str, Variable]:
    """Number and name of each wheel that works; a failed wheel has no entry and no torque.

    Numbers count all that are mounted, from 1.
    """
    if not wheels.count:
        return {}
    failed = {"failed": ", ".join(wheels.failed)} if wheels.failed else {}
    numbers = [place + 1 for place in wheels.working]
    return {
        "wheel": (("wheel",), numbers, {"long_name": "wheel"} | failed),
        "wheel_name": (("wheel",), list(wheels.names), {"long_name": "name of the wheel"}),
    }
