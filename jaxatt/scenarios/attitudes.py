"""Attitudes in a scenario: three angles or a quaternion."""

from __future__ import annotations

import numpy as np

from jaxatt.scenarios.fields import Table
from jaxatt.spacecraft.checks import Float64

_UNIT_TOLERANCE = 1e-9


def quaternion_from_angles(angles: Float64) -> Float64:
    """Return q_ob of roll, pitch, yaw [rad], (4,), scalar first: R = Rz(psi) Ry(theta) Rx(phi).

    Schaanning (2021), eq. 2.22, read as the rotation from body to orbit components. Computed in
    NumPy, so that a scenario is exact whatever precision JAX is set to.
    """
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles / 2.0), np.sin(angles / 2.0)
    return np.array(
        [
            cx * cy * cz + sx * sy * sz,
            sx * cy * cz - cx * sy * sz,
            cx * sy * cz + sx * cy * sz,
            cx * cy * sz - sx * sy * cz,
        ]
    )


def read_attitude(table: Table, notes: list[str]) -> Float64:
    """Return the unit quaternion q_ob of a table, (4,); a note says when it was normalised."""
    if "attitude_deg" in table and "attitude_quaternion" in table:
        table.fail(
            "attitude_quaternion",
            "given beside attitude_deg",
            "keep one of the two and drop the other",
        )
    if "attitude_quaternion" not in table:
        table.require("attitude_deg", "[0.0, 0.0, 0.0]")
        return quaternion_from_angles(np.deg2rad(table.vector("attitude_deg", 3)))
    quaternion = table.vector("attitude_quaternion", 4)
    # Scaling first keeps the norm of huge or tiny entries from overflowing.
    largest = float(np.abs(quaternion).max())
    if largest < 1e-12:
        table.fail(
            "attitude_quaternion",
            "is zero, which is no attitude",
            "give a unit quaternion, scalar first, e.g. [1.0, 0.0, 0.0, 0.0]",
        )
    scaled = quaternion / largest
    norm = float(np.linalg.norm(scaled))
    if abs(norm * largest - 1.0) > _UNIT_TOLERANCE:
        notes.append(
            f"{table.label} attitude_quaternion was normalised; its norm was {norm * largest:.6g}"
        )
    return scaled / norm
