"""Read the attitudes of an Attitude Ephemeris Message, relative to inertial axes."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jaxatt.attitude.attitude_path import through
from jaxatt.attitude.host_turns import conjugate, product, to_body
from jaxatt.exchange.aem_source import QUATERNION, Block, blocks
from jaxatt.exchange.attitude_checks import check_motion, check_norms
from jaxatt.exchange.moments import Instants, read, seconds_after, short
from jaxatt.exchange.motion import FileFormatError
from jaxatt.runtime.arrays import Floats

INERTIAL = ("EME2000", "J2000", "ICRF", "GCRF")
"""Names of frames that are taken for the package's; they differ by 0.03 arcsec at most."""
_BODY = ("SC_BODY", "SC_BODY_1")


@dataclass(frozen=True, eq=False)
class Segment:
    """Attitudes between which one may interpolate.

    moments : (n,), increasing.  q_ib : (n, 4), scalar first.  omega_ib : (n, 3) [rad/s], body axes.
    first, last : between which the file says that it may be used.
    """

    moments: Instants
    q_ib: Floats
    omega_ib: Floats
    first: np.datetime64
    last: np.datetime64


def read_aem(path: Path) -> list[Segment]:
    """Read all segments of a file, in the order of time.

    Raises `FileFormatError` where a frame or time system is not known, or the file contradicts
    itself.
    """
    found = [_segment(block) for block in blocks(path)]
    for before, after in itertools.pairwise(found):
        if after.first < before.last:
            raise FileFormatError(
                str(path),
                f"a segment begins at {short(after.first)}, before the one above it ends at "
                f"{short(before.last)}",
                "put the segments in order, without overlap",
            )
    return found


def _segment(block: Block) -> Segment:
    time_system = block.keywords.get("TIME_SYSTEM", "")
    if time_system != "UTC":
        raise FileFormatError(
            block.where, f"TIME_SYSTEM = {time_system}", "only UTC is read; convert the file"
        )
    moments = _moments(block)
    p = _numbers(block, QUATERNION)[:, [3, 0, 1, 2]]
    check_norms(p, moments, block.where)
    p = p / np.linalg.norm(p, axis=1, keepdims=True)
    backward = _backward(block)
    rates = _rates(block, p)
    if rates is not None:
        check_motion(seconds_after(moments[0], moments), p, rates, block.where)
    q, omega = p, rates
    if backward:
        q = conjugate(p)
        omega = None if rates is None else -to_body(q, rates)
    if omega is None and len(q) == 1:
        mend = "give two, or one with its rate"
        raise FileFormatError(block.where, "holds a single attitude without a rate", mend)
    if omega is None:
        omega = through(seconds_after(moments[0], moments), q).omega
    return Segment(moments, q, omega, *_usable(block, moments))


def _moments(block: Block) -> Instants:
    moments = np.array([_moment(stamp, block) for stamp, _ in block.rows])
    late = np.flatnonzero(np.diff(moments) <= np.timedelta64(0, "ns"))
    if late.size:
        k = int(late[0])
        raise FileFormatError(
            block.where,
            f"{block.rows[k + 1][0]} follows {block.rows[k][0]}",
            "its epochs must increase; sort them, or begin a segment of its own",
        )
    return moments


def _moment(stamp: str, block: Block) -> np.datetime64:
    try:
        return read(stamp)
    except ValueError:
        mend = "write it as 2026-06-21T12:00:00.000"
        raise FileFormatError(block.where, f"{stamp} is no moment", mend) from None


def _numbers(block: Block, names: tuple[str, ...]) -> Floats:
    """Columns (n, len(names)) of a block."""
    return np.array(
        [[_number(row[name], stamp, block) for name in names] for stamp, row in block.rows]
    )


def _number(text: str, stamp: str, block: Block) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        mend = "correct the row or drop it"
        raise FileFormatError(block.where, f"{text} at {stamp} is no number", mend)
    return value


def _backward(block: Block) -> bool:
    """Whether the file's quaternion is the turn of the body's axes into inertial ones."""
    keys = block.keywords
    frames = [keys.get(key, "").upper() for key in ("REF_FRAME_A", "REF_FRAME_B")]
    if frames[0] in INERTIAL and frames[1] in _BODY:
        backward = False
    elif frames[1] in INERTIAL and frames[0] in _BODY:
        backward = True
    else:
        raise FileFormatError(
            block.where,
            f"REF_FRAME_A = {frames[0] or 'nothing'} and REF_FRAME_B = {frames[1] or 'nothing'}",
            f"known are attitudes between {' or '.join(_BODY)} and one of {', '.join(INERTIAL)}; "
            "have the file written in these",
        )
    if block.version > 1:
        return backward
    direction = keys.get("ATTITUDE_DIR", "").upper()
    if direction not in ("A2B", "B2A"):
        raise FileFormatError(
            block.where,
            "ATTITUDE_DIR is missing, which says from which frame to which the turn is",
            "add ATTITUDE_DIR = A2B or B2A, as its writer had it",
        )
    return backward != (direction == "B2A")


def _rates(block: Block, p: Floats) -> Floats | None:
    """Rate (n, 3) [rad/s] of the frame that the turn ends in, in its axes; None where not given."""
    kind = block.keywords["ATTITUDE_TYPE"].upper()
    if kind == "QUATERNION/DERIVATIVE":
        slope = _numbers(block, tuple(f"{name}_DOT" for name in QUATERNION))[:, [3, 0, 1, 2]]
        return np.asarray(2.0 * product(conjugate(p), slope)[:, 1:])
    if kind != "QUATERNION/ANGVEL":
        return None
    rates = np.radians(_numbers(block, ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")))
    keys = block.keywords
    given = keys.get("ANGVEL_FRAME", keys.get("RATE_FRAME", "")).upper()
    if given in (keys["REF_FRAME_B"].upper(), "REF_FRAME_B"):
        return rates
    if given in (keys["REF_FRAME_A"].upper(), "REF_FRAME_A"):
        return to_body(p, rates)
    raise FileFormatError(
        block.where,
        f"ANGVEL_FRAME = {given or 'nothing'} is neither of the two frames",
        "name REF_FRAME_A's or REF_FRAME_B's, in whose axes the rates are",
    )


def _usable(block: Block, moments: Instants) -> tuple[np.datetime64, np.datetime64]:
    first, last = moments[0], moments[-1]
    if "USEABLE_START_TIME" in block.keywords:
        first = max(first, _moment(block.keywords["USEABLE_START_TIME"], block))
    if "USEABLE_STOP_TIME" in block.keywords:
        last = min(last, _moment(block.keywords["USEABLE_STOP_TIME"], block))
    return first, last
