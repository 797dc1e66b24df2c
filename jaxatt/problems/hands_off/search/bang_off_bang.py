"""Bang-off-bang supports: the first and the last intervals, none between.

Torque early and late has the longest lever, so slews that saturate use the ends of the horizon.
Trying every such support of a size is cheap, rescues searches that do not arrive, and is evidence
where none of a smaller size does.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from jaxatt.optimize.reweighting.bounded import BETWEEN_BOUNDS, BoundedReweighting
from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate, support_of
from jaxatt.problems.hands_off.search.polish import Method, polish, screen
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Flags, Floats

_NEARLY_HARD = 1e5
"""Weight of a squared row against that of a squared scaled control."""

_PLACES = 50
"""At most as many places are tried for one interval."""

_NEAREST = BoundedReweighting(
    replace(BETWEEN_BOUNDS, deciding=0, settling=40, settled_smoothing=1.0), reach=10.0
)


def bang_off_bang_supports(task: SparseTask, shapes: Iterable[tuple[int, int]]) -> Mask:
    """Supports (S, N, 1) of the first a and the last b intervals that are allowed."""
    allowed = np.flatnonzero((np.asarray(task.arguments.free) > 0).any(axis=1))
    made = []
    for first, last in shapes:
        support = np.zeros((task.intervals, 1), bool)
        support[allowed[:first]] = True
        support[allowed[len(allowed) - last :]] = True
        made.append(support)
    return np.unique(np.stack(made), axis=0)


def _both_ways(task: SparseTask, supports: Mask) -> tuple[Floats, Mask, Floats]:
    """Controls at rest and supports, once for each way round (1, then -1)."""
    twice = np.concatenate([supports, supports])
    sign = np.repeat([1.0, -1.0], len(supports))
    return np.zeros((len(twice), task.intervals, task.size)), twice, sign


def try_bang_off_bang(task: SparseTask, size: int, method: Method) -> Candidates:
    """Try every bang-off-bang support of `size` intervals, both ways round."""
    return screen(task, *_both_ways(task, bang_off_bang_supports(task, _shapes(size))), method)


def fewest_bang_off_bang(task: SparseTask, most: int, method: Method) -> Candidates | None:
    """Bang-off-bang answers of the least size below `most` that reaches; None where none does.

    By bisection: an interval more never takes a way from a support.
    """
    found, least = None, 0
    while most - least > 1:
        size = (least + most) // 2
        tried = try_bang_off_bang(task, size, method)
        if tried.verdict.reached.any():
            found, most = tried, size
        else:
            least = size
    return found


def one_between(task: SparseTask, found: Candidates, method: Method) -> Candidates | None:
    """Try one interval fewer than bang-off-bang answers: one less at each end, and one between.

    found : as `fewest_bang_off_bang` returns them.  None where there is no room between the ends.
    """
    reached = np.flatnonzero(found.verdict.reached)
    made = [supports_between(task, support_of(task, found.controls[k])) for k in reached]
    signs = np.repeat(found.sign[reached], [len(supports) for supports in made])
    if not len(signs):
        return None
    rest = np.zeros((len(signs), task.intervals, task.size))
    return screen(task, rest, np.concatenate(made), signs, method)


def supports_between(task: SparseTask, support: Mask) -> Mask:
    """Supports (S, N, 1) that leave out the intervals on both sides of the widest gap, for one in
    it, of a support (N, g); none where there is no room."""
    allowed = (np.asarray(task.arguments.free) > 0).any(axis=1)
    active = np.flatnonzero(support.any(axis=-1))
    if len(active) < 2:
        return np.zeros((0, task.intervals, 1), bool)
    gap = int(np.diff(active).argmax())
    inside = np.flatnonzero(allowed & _between(task.intervals, active[gap], active[gap + 1]))
    if not len(inside):
        return np.zeros((0, task.intervals, 1), bool)
    places = inside[np.unique(np.linspace(0, len(inside) - 1, _PLACES).round().astype(int))]
    made: Mask = np.zeros((len(places), task.intervals, 1), bool)
    made[:, np.delete(active, [gap, gap + 1])] = True
    made[np.arange(len(places)), places] = True
    return made


def _between(intervals: int, first: int, last: int) -> Flags:
    """Which intervals (N,) lie between two others."""
    index = np.arange(intervals)
    return np.asarray((index > first) & (index < last))


def nearest_bang_off_bang(
    task: SparseTask, size: int, method: Method, attempts: int = 4
) -> Candidates:
    """As `try_bang_off_bang`, but drive each support as near to the target as it gets.

    The squared errors are minimised within limits from `attempts` beginnings, at rest and random:
    what is left on the best of them tells how far out of reach a size is.
    """
    u, supports, sign = _both_ways(task, bang_off_bang_supports(task, _shapes(size)))
    rng = np.random.default_rng(0)
    count = len(u)
    u, supports, sign = (np.concatenate([part] * attempts) for part in (u, supports, sign))
    u[count:] = rng.uniform(size=u[count:].shape)
    free = np.broadcast_to(supports, u.shape) * np.asarray(task.arguments.free)
    lanes = broadcast_lanes(u * free, free, np.full(task.rows, _NEARLY_HARD), sign)
    found = method.run(task, _NEAREST, "roots", lanes, task.arguments)
    status = np.full(len(u), int(Status.FEASIBLE))
    steps = np.full(len(u), _NEAREST.settings.settling)
    return evaluate(task, np.asarray(found.u), status, steps, sign)


def _shapes(size: int) -> list[tuple[int, int]]:
    return [(first, size - first) for first in range(size + 1)]


def cheapest_bang_off_bang(task: SparseTask, most: int, method: Method) -> Candidates:
    """Try torque at the start only, or as long at the end too, for every length up to `most`."""
    shapes = [(first, last) for first in range(1, most + 1) for last in (0, first)]
    return polish(task, *_both_ways(task, bang_off_bang_supports(task, shapes)), method)
