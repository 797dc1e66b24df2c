"""Attitudes in a scenario file: Euler angles, a quaternion, MRP, or an axis with an angle."""

from __future__ import annotations

import math

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.attitude import AIM_KEYS, FILE_KEYS
from jaxatt.spacecraft.checks import Float64

_UNIT_TOLERANCE = 1e-9
# Rounded axes such as 0.57735 are meant as unit vectors: only a larger deviation earns a note.
_AXIS_TOLERANCE = 1e-5
# Beyond it an MRP stands for less than 1e-3 deg short of a whole turn.
_LARGEST_MRP = 1e5

_AIMED = tuple(AIM_KEYS)
_TURNED = ("axis", "angle_deg", "angle_rad")
_FORMS = (("attitude_deg",), ("attitude_quaternion",), ("attitude_mrp",), _TURNED, _AIMED)
_WHOLE_TURN = (
    "stands for a turn of 360 deg, where sigma = axis tan(angle/4) is infinite",
    "[0.0, 0.0, 0.0] is the same attitude",
)


def quaternion_from_angles(angles: Float64) -> Float64:
    """Return the quaternion q_ob (4,) of roll, pitch and yaw [rad]: R = Rz(psi) Ry(theta) Rx(phi).

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


def attitude_given(table: Table) -> bool:
    """Return whether a table states an attitude in any form."""
    return any(key in table for form in _FORMS for key in form)


def replaced_by(key: str) -> tuple[str, ...]:
    """Return the keys that a new value under `key` replaces: all other forms of an attitude."""
    every = tuple(other for form in _FORMS for other in form)
    if key in FILE_KEYS:
        return (*every, "rate_rad_s", "rate")
    if key not in every:
        return ()
    same = next(form for form in _FORMS if key in form)
    kept = ("axis",) if key.startswith("angle_") else same
    return (*(other for other in every if other not in kept), *FILE_KEYS)


def check_one_form(table: Table) -> None:
    """Refuse a table that states its attitude in two forms."""
    _form(table)


def _form(table: Table) -> tuple[str, ...]:
    """Keys of the form in which a table states its attitude, angles by default."""
    given = [form for form in _FORMS if any(key in table for key in form)]
    if len(given) > 1:
        first, second = (next(key for key in form if key in table) for form in given[:2])
        table.fail(second, f"given beside {first}", "keep one of the two and drop the other")
    return given[0] if given else _FORMS[0]


def read_attitude(table: Table, notes: list[str]) -> Float64:
    """Read the unit quaternion q_ob of a table, (4,); a note says when it was normalised."""
    form = _form(table)
    if form is _AIMED:
        table.fail(
            next(key for key in form if key in table),
            "not in this table, where the attitude must be fixed",
            "give attitude_deg",
        )
    if form is _TURNED:
        return _from_axis(table, notes)
    if "attitude_mrp" in form:
        return _from_mrp(table)
    if "attitude_quaternion" in form:
        return _from_quaternion(table, notes)
    table.require("attitude_deg")
    return quaternion_from_angles(np.deg2rad(table.vector("attitude_deg")))


def _from_quaternion(table: Table, notes: list[str]) -> Float64:
    quaternion = table.vector("attitude_quaternion")
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


def _from_mrp(table: Table) -> Float64:
    sigma = table.vector("attitude_mrp")
    if np.abs(sigma).max() > _LARGEST_MRP:
        table.fail("attitude_mrp", *_WHOLE_TURN)
    squared = float(sigma @ sigma)
    return np.concatenate([[1.0 - squared], 2.0 * sigma]) / (1.0 + squared)


def _from_axis(table: Table, notes: list[str]) -> Float64:
    axis = table.vector("axis")
    key = "angle_rad" if "angle_rad" in table else "angle_deg"
    whole, unit = (2.0 * math.pi, "rad") if key == "angle_rad" else (360.0, "deg")
    angle = table.number(key)
    if abs(abs(angle) - whole) < 1e-9 * whole:
        table.fail(key, *_WHOLE_TURN[:1], "an angle of 0 is the same attitude")
    if abs(angle) > whole:
        table.fail(key, "more than a whole turn", f"give an angle within {whole:.6g} {unit}")
    largest = float(np.abs(axis).max())
    if largest < 1e-12:
        table.fail("axis", "is zero, which is no direction", "give the axis of the turn")
    scaled = axis / largest
    norm = float(np.linalg.norm(scaled))
    if abs(norm * largest - 1.0) > _AXIS_TOLERANCE:
        notes.append(f"{table.label} axis was normalised; its length was {norm * largest:.6g}")
    half = math.pi * angle / whole
    return np.concatenate([[math.cos(half)], math.sin(half) * scaled / norm])
