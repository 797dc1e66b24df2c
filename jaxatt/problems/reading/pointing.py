"""Read cones and rate limits of a scenario: [[keep_out]], [[keep_in]] and [limits]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from jaxatt.attitude.free_roll import facing
from jaxatt.attitude.host_turns import product, to_body, turned_by
from jaxatt.problems.pointing.case import Cone, Pointing
from jaxatt.problems.reading.directions import Sky, check_sight, read_direction
from jaxatt.problems.reading.faults import UNSOUND, Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.spacecraft.checks import Float64

_ROUNDING = 1e-9  # rad; a boresight on the cone itself is allowed
_ROLLS = 720
_BETWEEN_ROLLS = 1.01 * math.pi / _ROLLS
"""[rad] By which angles may be nearer to a limit between two of the rolls that are tried."""

_INSTANTS = 33
"""Of a motion, at which keep-in cones are compared with each other."""


class Moment(NamedTuple):
    """An attitude that a scenario prescribes at an instant, with its name in messages.

    time : [s].  q_ob : (4,).  omega_ob : (3,) [rad/s].  q_io : (4,) and omega_io : (3,) [rad/s], of
    the orbit frame then.  boresight : (3,), body axis about which any roll will do; None if none.
    """

    label: str
    time: float
    q_ob: Float64
    omega_ob: Float64
    q_io: Float64
    omega_io: Float64
    boresight: Float64 | None = None


def read_pointing(
    document: dict[str, Any],
    origin: str,
    notes: list[str],
    sky: Sky,
    first: float,
    last: float,
) -> Pointing:
    """Read and check the cones and rate limits of a document.

    notes : what is to be said is added.  sky : what directions may be told by.
    first, last : [s], the shortest and longest that the motion takes.
    Raises `ScenarioError`.
    """
    faults = Faults()
    cones: list[Cone] = []
    for key, kind in (("keep_out", "keep-out"), ("keep_in", "keep-in")):
        tables = document.get(key, [])
        if not isinstance(tables, list):
            raise ScenarioError(
                f"{origin}: {key}: must be a list of tables; write [[{key}]] with double brackets"
            )
        for index, data in enumerate(tables):
            label = f"[[{key}]] no. {index + 1}"
            table = faults.of(Table, data, origin, label, SPACECRAFT_TABLES[key])
            cone = faults.of(_cone, table, kind, notes, sky, first, last, cones)
            if cone is not UNSOUND:
                cones.append(cone)
    limit = faults.of(_rate_limit, document.get("limits", {}), origin)
    faults.refuse()
    pointing = Pointing(tuple(cones), limit)
    _check_together(pointing, first, origin)
    return pointing


def _cone(
    table: Table,
    kind: str,
    notes: list[str],
    sky: Sky,
    first: float,
    last: float,
    others: Sequence[Cone],
) -> Cone:
    name = table.text("name")
    if name in (other.name for other in others):
        table.fail("name", "another cone has it", "give every cone a name of its own")
    half = table.number("half_angle_deg")
    if half >= 180.0:
        table.fail("half_angle_deg", "must be less than 180", "give half of the cone's opening")
    boresight = table.direction("boresight")
    direction, words = read_direction(table, notes, sky, last)
    if kind == "keep-in":
        for time in (0.0, first):
            check_sight(table, "toward", (direction, words), sky, time)
    return Cone(name, kind, boresight, math.radians(half), direction)


def _rate_limit(data: Any, origin: str) -> Float64 | None:
    table = Table(data, origin, "[limits]", SPACECRAFT_TABLES["limits"])
    key = "body_rate_deg_s"
    if key not in table:
        return None
    if isinstance(table.data[key], list):
        limit = table.vector(key)
        if not (limit > 0.0).all():
            table.fail(key, "must be greater than 0", "give three positive numbers, or one for all")
    else:
        limit = np.full(3, table.number(key))
    return np.deg2rad(limit)


def _between(a: Float64, b: Float64) -> Float64:
    """Angles (...) [rad] between vectors (..., 3)."""
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.asarray(np.arctan2(across, (a * b).sum(axis=-1)))


def _check_together(pointing: Pointing, last: float, origin: str) -> None:
    """Check that two keep-in cones leave some attitude that satisfies both, all the time.

    last : [s], of the shortest motion.
    """
    inner = [cone for cone in pointing.cones if cone.kind == "keep-in"]
    if len(inner) < 2:
        return
    times = np.linspace(0.0, last, _INSTANTS)
    directions = Pointing(tuple(inner)).directions(times)
    for i, first in enumerate(inner):
        for j, second in enumerate(inner[:i]):
            apart = float(_between(first.boresight, second.boresight))
            wanted = _between(directions[:, i], directions[:, j])
            k = int(np.argmax(np.abs(apart - wanted)))
            if abs(apart - wanted[k]) > first.half_angle + second.half_angle + _ROUNDING:
                raise ScenarioError(
                    f'{origin}: [[keep_in]] "{second.name}" and "{first.name}" exclude each other '
                    f"{times[k]:.4g} s after the start: their boresights are "
                    f"{math.degrees(apart):.4g} deg apart, their directions "
                    f"{math.degrees(wanted[k]):.4g} deg, and the half angles leave "
                    f"{math.degrees(first.half_angle + second.half_angle):.4g} deg; widen one or "
                    "drop it"
                )


def check_moments(pointing: Pointing, moments: Sequence[Moment], origin: str) -> None:
    """Raise a `ScenarioError` where a start, waypoint or target itself violates a limit.

    Where any roll will do, that is one which every roll violates.
    """
    if not pointing or not moments:
        return
    directions = pointing.directions(np.array([moment.time for moment in moments]))
    boresights = np.reshape([cone.boresight for cone in pointing.cones], (-1, 3))
    halves = np.array([cone.half_angle for cone in pointing.cones])
    senses = np.array([cone.sense for cone in pointing.cones])
    for moment, toward in zip(moments, directions, strict=True):
        q_ob, omega_ob = _rolled(moment)
        seen = to_body(product(moment.q_io, q_ob)[:, None], toward)
        angles = _between(boresights, seen)
        rates = omega_ob + to_body(q_ob, moment.omega_io)
        worst = np.max(senses * (angles - halves), axis=1, initial=-np.inf) - _BETWEEN_ROLLS
        if pointing.rate_limit is not None:
            between = _BETWEEN_ROLLS * np.linalg.norm(rates, axis=1, keepdims=True)
            over = (np.abs(rates) - between) / pointing.rate_limit - 1.0
            worst = np.maximum(worst, over.max(axis=1))
        label, best = moment.label, int(np.argmin(worst))
        if moment.boresight is not None:
            if worst[best] <= 0.0:
                continue
            label = f"{label} (at the roll that suits best)"
        for cone, angle in zip(pointing.cones, angles[best], strict=True):
            if cone.sense * (angle - cone.half_angle) > _ROUNDING:
                _refuse(cone, float(angle), label, origin)
        _check_rate(pointing.rate_limit, rates[best], label, origin)


def _rolled(moment: Moment) -> tuple[Float64, Float64]:
    """Attitudes (R, 4) and rates (R, 3) that will do: one, or rolled all the way round."""
    if moment.boresight is None:
        return moment.q_ob[None], moment.omega_ob[None]
    roll = np.linspace(0.0, 2.0 * np.pi, _ROLLS, endpoint=False)
    turned = product(moment.q_ob, turned_by(roll[:, None] * moment.boresight))
    return facing(moment.q_ob, moment.omega_ob, moment.boresight, turned)


def _refuse(cone: Cone, angle: float, label: str, origin: str) -> None:
    out = cone.kind == "keep-out"
    key = cone.kind.replace("-", "_")
    raise ScenarioError(
        f'{origin}: [[{key}]] "{cone.name}" {"contains" if out else "excludes"} the {label}: the '
        f"boresight is {math.degrees(angle):.5g} deg from the direction there, "
        f"half_angle_deg = {math.degrees(cone.half_angle):.5g}; "
        f"{'narrow' if out else 'widen'} the cone, or change the attitude"
    )


def _check_rate(limit: Float64 | None, rate: Float64, label: str, origin: str) -> None:
    if limit is not None and (np.abs(rate) > limit * (1.0 + _ROUNDING)).any():
        raise ScenarioError(
            f"{origin}: [limits] body_rate_deg_s = {np.round(np.rad2deg(limit), 6).tolist()}: the "
            f"{label} turns at {np.round(np.rad2deg(rate), 6).tolist()} deg/s relative to the "
            "inertial frame; raise the limit or begin and end slower"
        )
