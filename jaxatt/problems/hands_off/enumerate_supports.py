"""Certificate of one phase, by trying every cheaper support and all that cost as much."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from jaxatt.problems.hands_off.certificate import ClassRecord, PhaseCertificate
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.enumeration import (
    SupportClass,
    classes_up_to,
    enumerate_class,
    group_weights,
    masks_of,
)
from jaxatt.problems.hands_off.search.polish import Method, polish
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.records.phase import Phase
from jaxatt.runtime.chunks import Report, chunk_for

_ATTEMPTS = 4
_FLOWN = 32
_SECONDS_A_SUPPORT = 2e-4


def certify_support(
    task: SparseTask, phase: Phase, most: int, seed: int, report: Report | None
) -> PhaseCertificate:
    """Try the supports that cost less than a phase's answer, and those that cost as much.

    most : supports of a class beyond which it counts as out of reach.
    report : called by the host with (stage, supports tried).
    """
    if not phase.reached:
        return PhaseCertificate(phase, math.inf, (), (), None, None, False)
    weight = group_weights(task)
    cost = float(np.nansum(weight[support_of(task, phase.controls)]))
    classes = classes_up_to(task, cost)
    tie = cost * (1.0 - 1e-9)
    rate = _SECONDS_A_SUPPORT
    signs = task.ways
    rows = chunk_for(len(phase.starts.status))  # as in the search: nothing is compiled again

    def tried(kind: SupportClass, attempts: int, thorough: bool) -> ClassRecord:
        nonlocal rate
        if kind.number > most:
            return ClassRecord(kind, None, None, len(signs) * rate * attempts * kind.number)
        stage = f"trying supports of {kind.size}"
        progress = None if report is None else lambda done: report(stage, done)
        method = Method("l0", rows=rows, progress=progress)
        ways = [
            enumerate_class(task, kind, sign, method, attempts, seed, thorough) for sign in signs
        ]
        seconds = sum(way.seconds for way in ways)
        if kind.number >= 500:
            rate = seconds / (len(signs) * attempts * kind.number)
        return ClassRecord(kind, ways[0], ways[1] if len(ways) > 1 else None, seconds)

    same = [kind for kind in classes if kind.cost >= tie]
    equal = tuple(tried(kind, 1, False) for kind in same)
    own = np.argwhere(support_of(task, phase.controls))
    if not _finds(equal, own):
        # Limits bind too much for the quick way, as the answer's own support shows.
        equal = tuple(tried(kind, 1, True) for kind in same)
    cheaper = tuple(tried(kind, _ATTEMPTS, True) for kind in classes if kind.cost < tie)
    best, effort, long_way = _best(task, equal, rows)
    consistent = _finds(equal, own) or not all(record.tried for record in equal)
    return PhaseCertificate(phase, cost, cheaper, equal, best, effort, long_way, consistent)


def _finds(records: Sequence[ClassRecord], support: npt.NDArray[np.int64]) -> bool:
    """Whether a support that is known to reach was found again."""
    return any(
        way is not None
        and way.groups.shape[1:] == support.shape
        and bool((way.reached & (way.groups == support[None]).all(axis=(1, 2))).any())
        for record in records
        for way in (record.short, record.long)
    )


def _best(
    task: SparseTask, records: Sequence[ClassRecord], rows: int
) -> tuple[npt.NDArray[np.int64] | None, float | None, bool]:
    """The support of least L1 effort among those that reach, polished and verified in flight."""
    ways: list[tuple[float, npt.NDArray[np.int64], float]] = []
    for record in records:
        for sign, way in ((1.0, record.short), (-1.0, record.long)):
            if way is None:
                continue
            order = np.argsort(np.where(way.reached, way.effort, np.inf))[:_FLOWN]
            ways += [(float(way.effort[i]), way.groups[i], sign) for i in order if way.reached[i]]
    ways = sorted(ways, key=lambda entry: entry[0])[:_FLOWN]
    if not ways:
        return None, None, False
    masks = np.concatenate([masks_of(task, groups[None]) for _, groups, _ in ways])
    signs = np.asarray([sign for _, _, sign in ways])
    rest = np.zeros((len(ways), task.intervals, task.size))
    ended = polish(task, rest, masks, signs, Method("l0", rows=rows))
    flown = np.where(ended.verdict.reached, ended.rank[:, -1], np.inf)
    index = int(np.argmin(flown))
    if not np.isfinite(flown[index]):
        return None, None, False
    return ways[index][1], float(flown[index]), bool(signs[index] < 0)
