"""Read states: attitudes by numbers, by where body axes point or from a file, and rates."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.attitude.free_roll import across, nearest_roll
from jaxatt.attitude.host_turns import conjugate, product, to_body
from jaxatt.environment import toward
from jaxatt.problems.along_orbit import along_orbit, from_inertial, to_inertial
from jaxatt.problems.reading.attitude_files import read_path, refuse_beside_file
from jaxatt.problems.reading.attitudes import check_one_form, read_attitude
from jaxatt.problems.reading.directions import Aim, Sky, check_sight, read_aim
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.attitude import AIM_KEYS, DIRECTION_KEYS, POSE_KEYS
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.spacecraft.checks import Float64

_LEAST_APART = 0.1
"""[deg] Two axes nearer to each other, or to opposite, leave the roll to chance."""
_MOVED = 1e-4
"""[deg] By which an attitude may differ between the shortest and the longest final time."""
_LONG = 600.0
"""[s] After which a direction that moves has moved, where there is no longest final time."""
_CHECKED = 65
"""Instants at which directions that are followed are checked."""
_ALONG = 1e-12
"""[rad/s] Rates across a body axis that count as none."""

_pose = jax.jit(toward.pose, compiler_options=RUNS_ONCE)
_poses = jax.jit(jax.vmap(toward.pose, (None, None, None, None, 0)), compiler_options=RUNS_ONCE)
_apart = jax.jit(toward.apart, compiler_options=RUNS_ONCE)


def read_state(
    table: Table, notes: list[str], sky: Sky, first: float, last: float | None = None
) -> tuple[Float64, Float64]:
    """Read attitude (4,) and rate (3,) [rad/s] of the body relative to the sky's frame.

    The rate is that of `rate_rad_s`, 0 by default, or what `rate` says in words.
    first, last : [s] between which the attitude is to be had; what moves in between is refused.
    Raises `ScenarioError`.
    """
    _refuse_free_roll(table)
    return _read_state(table, notes, sky, first, last)


def _refuse_free_roll(table: Table) -> None:
    if "align" in table and "constrain" not in table:
        table.fail(
            "constrain",
            "missing beside align; only a target may leave the roll about one axis free",
            'add constrain = { body = [1.0, 0.0, 0.0], toward = "velocity" }',
        )


def read_goal(
    table: Table, notes: list[str], sky: Sky, first: float, last: float | None = None
) -> tuple[Float64, Float64, Float64 | None]:
    """Read what a manoeuvre ends with: as `read_state`, and the body axis (3,) whose roll is free.

    That is the one of `align` where no other is constrained; None elsewhere.
    """
    q, rate = _read_state(table, notes, sky, first, last)
    if "align" not in table or "constrain" in table:
        return q, rate, None
    boresight = _boresight(table)
    if "rate_rad_s" in table and np.linalg.norm(np.cross(rate, boresight)) > _ALONG:
        table.fail(
            "rate_rad_s",
            "has parts across the body axis, whose direction depends on the roll that is free",
            'give a rate about that axis, use rate = "orbit", "inertial" or "track", or add '
            "constrain",
        )
    return q, rate, boresight


def _boresight(table: Table) -> Float64:
    return Table(
        table.data["align"], table.origin, f"{table.label} align", DIRECTION_KEYS
    ).direction("body")


def _read_state(
    table: Table, notes: list[str], sky: Sky, first: float, last: float | None
) -> tuple[Float64, Float64]:
    if "aem_file" in table:
        return _in_file(table, sky, first)
    if "at" in table:
        table.fail("at", "given without aem_file", "name the file, or drop it")
    aimed, told = _aimed_and_told(table, sky)
    if not aimed:
        q = read_attitude(table, notes)
        return q, _rate(table, told, q, sky, first, np.zeros(3))
    aims = _read_aims(table, notes, sky, first, last)
    q, rate = _aimed(table, aims, sky, first)
    if last is not None and last > first:
        later, _ = _aimed(table, aims, sky, min(last, first + _LONG))
        if aims[1] is None:
            later = nearest_roll(later, aims[0].body, q)
        moved = math.degrees(2.0 * math.acos(min(1.0, abs(float(q @ later)))))
        if moved > _MOVED:
            table.fail(
                "align",
                f"moves by {moved:.3g} deg between the shortest and the longest final time",
                "fix the final time, or point along what rests in the frame of the attitudes",
            )
    return q, _rate(table, told, q, sky, first, rate)


def read_followed(table: Table, notes: list[str], sky: Sky, times: Floats) -> AttitudePath | None:
    """Read the inertial attitudes of a body that follows its directions, or rests among the stars.

    times : (n,) [s], n of at least 2, of the attitudes.

    None unless the table says `rate = "track"` or `"inertial"`.  Raises `ScenarioError`.
    """
    _, told = _aimed_and_told(table, sky)
    if told == "track":
        _refuse_free_roll(table)
        first, second = _read_aims(table, notes, sky, float(times[0]), float(times[-1]))
        assert second is not None
        for time in times[np.linspace(0, len(times) - 1, _CHECKED).astype(int)]:
            _check(table, (first, second), sky, float(time))
        with jax.enable_x64(True):
            found = _poses(first.body, first.direction, second.body, second.direction, times)
            return AttitudePath(times, *map(np.asarray, found))
    if told == "inertial":
        q, rate = read_state(table, notes, sky, float(times[0]))
        motion = sky.motion if sky.frame == "orbit" else None
        q_ib, _ = to_inertial(motion, times[:1], q[None], rate[None])
        return AttitudePath(times[[0, -1]], np.repeat(q_ib, 2, axis=0), np.zeros((2, 3)))
    return None


def _aimed_and_told(table: Table, sky: Sky) -> tuple[bool, str]:
    """Whether a table points along directions, and its `rate`, checked; "" without."""
    aimed = any(key in table for key in AIM_KEYS)
    told = table.choice("rate") if "rate" in table else ""
    if told and "rate_rad_s" in table:
        table.fail("rate", "given beside rate_rad_s", "keep one of the two and drop the other")
    if told == "track" and not aimed:
        table.fail("rate", "there is nothing to track", 'add align, or use rate = "inertial"')
    if told == "orbit" and sky.motion is None:
        table.fail("rate", "there is no [orbit]", 'add one, or use rate = "inertial"')
    return aimed, told


def _in_file(table: Table, sky: Sky, time: float) -> tuple[Float64, Float64]:
    """Attitude and rate that a CCSDS file has at a time."""
    refuse_beside_file(table, (*POSE_KEYS, "rate_rad_s", "rate"))
    instant = np.array([time])
    found = read_path(table, sky.folder, sky.days, time, time).at(instant)
    q, rate = from_inertial(sky.motion if sky.frame == "orbit" else None, instant, *found)
    return q[0], rate[0]


def _rate(table: Table, told: str, q: Float64, sky: Sky, time: float, tracking: Float64) -> Float64:
    """Rate relative to the sky's frame; tracking : that of an attitude that follows its aims."""
    if not told:
        return table.vector("rate_rad_s", 3, np.zeros(3))
    if told == "track":
        return tracking
    if sky.motion is None or told == sky.frame:
        return np.zeros(3)
    here = along_orbit(sky.motion, np.array([time]))
    q_ob = q if sky.frame == "orbit" else product(conjugate(here.q_io[0]), q)
    carried = to_body(q_ob, here.omega_io[0])
    return carried if told == "orbit" else -carried


def _aimed(
    table: Table, aims: tuple[Aim, Aim | None], sky: Sky, time: float
) -> tuple[Float64, Float64]:
    """Attitude and tracking rate at a time, relative to the sky's frame; with some roll if free."""
    first, second = aims[0], aims[1] or _any_roll(aims[0], time)
    _check(table, (first, second), sky, time)
    motion = sky.motion if sky.frame == "orbit" else None
    with jax.enable_x64(True):
        found = _pose(first.body, first.direction, second.body, second.direction, float(time))
        posed = (np.asarray(part)[None] for part in found)
    q, rate = from_inertial(motion, np.array([time]), *posed)
    return np.where(q[0, 0] < 0.0, -q[0], q[0]), rate[0]


def _check(table: Table, aims: tuple[Aim, Aim], sky: Sky, time: float) -> None:
    """Refuse directions that meet at a time [s], or that are out of sight."""
    first, second = aims
    with jax.enable_x64(True):
        wanted = math.degrees(float(_apart(first.direction, second.direction, time)))
    if not _LEAST_APART < wanted < 180.0 - _LEAST_APART:
        table.fail(
            "constrain",
            f"{second.words} stands {wanted:.3g} deg from {first.words} {time:.4g} s after the "
            "start, which leaves the roll to chance",
            "constrain an axis toward something else",
        )
    for aim in aims:
        check_sight(table, aim.key, (aim.direction, aim.words), sky, time)


def _any_roll(aligned: Aim, time: float) -> Aim:
    """A second axis whose direction rests among the stars, across the first one's at a time.

    So the attitude has some roll, and to follow the first direction it does not turn about it.
    """
    with jax.enable_x64(True):
        direction = np.asarray(aligned.direction.at(jnp.asarray(float(time))))
    stars = toward.AmongStars(across(direction / np.linalg.norm(direction))[0])
    return Aim("align", across(aligned.body)[0], stars, "any direction across it")


def _read_aims(
    table: Table, notes: list[str], sky: Sky, first: float, last: float | None
) -> tuple[Aim, Aim | None]:
    if "align" not in table:
        table.fail(
            "align",
            "missing beside constrain",
            'add align = { body = [0.0, 0.0, 1.0], toward = "nadir" }',
        )
    check_one_form(table)
    longest = first if last is None else last
    aligned = read_aim(table, "align", notes, sky, longest)
    if "constrain" not in table:
        return aligned, None
    constrained = read_aim(table, "constrain", notes, sky, longest)
    between = math.degrees(float(np.arccos(np.clip(aligned.body @ constrained.body, -1.0, 1.0))))
    if not _LEAST_APART < between < 180.0 - _LEAST_APART:
        table.fail(
            "constrain",
            f"its body axis stands {between:.3g} deg from the one that is aligned",
            "constrain another axis",
        )
    return aligned, constrained
