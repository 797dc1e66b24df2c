"""Attitude at any time between the instants of an attitude file, where the file has no gap."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace
from pathlib import Path

import numpy as np

from jaxatt.attitude.attitude_path import AttitudePath, turn_between
from jaxatt.attitude.host_turns import product, turned_by
from jaxatt.exchange.aem_reading import Segment, read_aem
from jaxatt.exchange.moments import instants, seconds_after, short
from jaxatt.exchange.motion import FileFormatError
from jaxatt.runtime.arrays import Floats

_GAP = 5.0
"""Times the usual step that makes a longer one a gap, unless the body hardly turns in it."""
_TURNED = 0.02
"""[rad] in a step below which it is no gap."""
_FARTHEST = 2.0
"""[rad] between two attitudes beyond which the way between them is not known."""
_SLACK = np.timedelta64(1_000_000, "ns")
"""Rounding of the times in a file."""


def path_of(file: Path, epoch: dt.datetime, first: float, last: float) -> AttitudePath:
    """Path through a file's attitudes that covers a span of time, in inertial axes.

    epoch : UTC of time zero.  first, last : [s] after it; the same for one instant.
    Raises `FileFormatError` where the file does not cover the span without a gap.
    """
    begin, end = instants(epoch, np.array([first, last]))
    segments = _joined(read_aem(file))
    within = [s for s in segments if s.first - _SLACK <= begin and end <= s.last + _SLACK]
    if not within:
        _refuse(file, segments, begin, end)
    segment = within[0]
    zero = instants(epoch, np.zeros(1))[0]
    time = seconds_after(zero, segment.moments)
    _check_gaps(file, segment, time, first, last)
    path = AttitudePath(time, segment.q_ib, segment.omega_ib)
    return _held(path) if len(time) == 1 else path


def _joined(segments: list[Segment]) -> list[Segment]:
    """Segments, where those that meet in one instant with one attitude are one."""
    joined = segments[:1]
    for segment in segments[1:]:
        before = joined[-1]
        meet = before.moments[-1] == segment.moments[0]
        turn = turn_between(np.stack([before.q_ib[-1], segment.q_ib[0]]))
        if meet and np.linalg.norm(turn) < 1e-6:
            joined[-1] = replace(
                segment,
                moments=np.concatenate([before.moments, segment.moments[1:]]),
                q_ib=np.concatenate([before.q_ib, segment.q_ib[1:]]),
                omega_ib=np.concatenate([before.omega_ib, segment.omega_ib[1:]]),
                first=before.first,
            )
        else:
            joined.append(segment)
    return joined


def _held(path: AttitudePath) -> AttitudePath:
    """Path of a single attitude and its rate, as two instants."""
    q = np.concatenate([path.q, product(path.q, turned_by(path.omega))])
    return AttitudePath(path.time[0] + np.array([0.0, 1.0]), q, path.omega[[0, 0]])


def _refuse(file: Path, segments: list[Segment], begin: np.datetime64, end: np.datetime64) -> None:
    spans = [f"{short(s.first)} to {short(s.last)}" for s in segments[:4]]
    more = f" and {len(segments) - 4} more" if len(segments) > 4 else ""
    asked = short(begin) if begin == end else f"{short(begin)} to {short(end)}"
    raise FileFormatError(
        str(file),
        f"is asked for {asked}",
        f"it has attitudes from {', '.join(spans)}{more}, and nothing is taken across its ends",
    )


def _check_gaps(file: Path, segment: Segment, time: Floats, first: float, last: float) -> None:
    """Refuse steps within a span of time that are far longer than the others, or turn too far."""
    if len(time) < 2:
        return
    step = np.diff(time)
    turned = np.linalg.norm(turn_between(segment.q_ib), axis=1)
    spun = step * np.linalg.norm(segment.omega_ib[:-1], axis=1)
    moved = np.maximum(turned, spun)
    wide = (step > _GAP * np.median(step)) & (moved > _TURNED)
    needed = (time[1:] > first) & (time[:-1] < last)
    gaps = np.flatnonzero(needed & (wide | (moved > _FARTHEST)))
    if gaps.size:
        k = int(gaps[0])
        between = f"from {short(segment.moments[k])} to {short(segment.moments[k + 1])}"
        angle = f"turns by {np.degrees(moved[k]):.3g} deg"
        if not wide[k]:
            mend = "the way between is not known; have attitudes written more often"
            raise FileFormatError(str(file), f"{angle} {between}", mend)
        raise FileFormatError(
            str(file),
            f"has a gap of {step[k]:g} s {between}, in which the body {angle}",
            f"its usual step is {np.median(step):g} s; have the gap filled, or stay beside it",
        )
