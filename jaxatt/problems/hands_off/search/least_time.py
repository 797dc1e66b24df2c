"""Least final time of a support, and exchange of supports at other final times.

Which final times a support of active intervals allows is decided by the torque limits: from its
least final time on it reaches.  So a count and a price for the time make one threshold for every
support: the final time at which it would cost less than the best answer so far.  All supports of
one count share it and are tried side by side.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from jaxatt.optimize.reweighting.support import Mask, neighbours
from jaxatt.problems.hands_off.search.bang_off_bang import bang_off_bang_supports
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.polish import SCREENING, Method, polish
from jaxatt.problems.hands_off.search.time_cost import Ledger, Offer, Rebuild, cheaper
from jaxatt.problems.hands_off.search.time_dilation import dilate_time
from jaxatt.problems.hands_off.task import SparseTask

TOLERANCE = 1e-4
"""Relative width to which bisection narrows a least final time."""

NEAR = 0.03
"""The same before the step becomes a variable."""

_GALLOP = 0.8
_ROUNDS = 40
_LONGER_BURST = 1
"""Intervals by which torque at one end may be longer than at the other."""


def shorten(offer: Offer, rebuild: Rebuild, method: Method, ledger: Ledger) -> Offer:
    """Shorten a support's answer to its least final time.

    Bisection on whether the least effort on it, within all limits, reaches leads near it:  shorter
    and shorter until it does not, then in between.  Final times between which it fails are not
    looked for.  From there a programme with the step as a variable leads to it;  where that does
    not succeed, bisection goes on.
    """
    support = support_of(offer.task, offer.answer.controls[0])
    good, bad = _bisected(offer, 0.0, NEAR, support, rebuild, method, ledger)
    least = dilate_time(good, rebuild, ledger) if support.any() else None
    if least is not None and least.cost <= good.cost:
        return least
    return _bisected(good, bad, TOLERANCE, support, rebuild, method, ledger)[0]


def _bisected(
    good: Offer,
    bad: float,
    tolerance: float,
    support: Mask,
    rebuild: Rebuild,
    method: Method,
    ledger: Ledger,
) -> tuple[Offer, float]:
    """A final time at which a support reaches, and a shorter one at which it does not, or zero."""
    lowest = ledger.pricing.lowest
    while good.final_time - max(lowest, bad) > tolerance * good.final_time:
        shorter = math.sqrt(bad * good.final_time) if bad else _GALLOP * good.final_time
        tried = _on(good, support, max(lowest, shorter), rebuild, method, ledger)
        if tried.cost <= good.cost:
            good = tried
        else:
            bad = tried.final_time
    return good, bad


def _on(
    like: Offer,
    support: Mask,
    final_time: float,
    rebuild: Rebuild,
    method: Method,
    ledger: Ledger,
) -> Offer:
    """Best answer of a support at another final time, from a known answer and from rest."""
    task = rebuild(like.task, final_time)
    # The same turn in less time: torques grow with the square of the rate of time.
    faster = (like.final_time / final_time) ** 2
    u = task.from_controls(like.answer.controls) * faster
    both, supports = np.concatenate([u, np.zeros_like(u)]), np.stack([support, support])
    ended = polish(task, both, supports, np.repeat(like.answer.sign, 2), method, SCREENING)
    # Doing nothing stays on a target that is the start within its tolerances only.
    return ledger.offer(task, ended, "support", exact=bool(support.any()))


def exchange(
    offer: Offer, others: Sequence[Mask], rebuild: Rebuild, method: Method, ledger: Ledger
) -> Offer:
    """Replace the support by cheaper ones, each at its least final time, while that pays.

    Tried are `others`, supports with one interval dropped, moved or added, with one added to each
    side of every run of active intervals, and bang-off-bang supports of any length.
    """
    best = offer
    for _ in range(_ROUNDS):
        found = _exchanged(best, others, rebuild, method, ledger)
        if found is None:
            break
        best = shorten(found, rebuild, method, ledger)
    return best


def finish(offer: Offer, method: Method, ledger: Ledger) -> Offer:
    """Minimise the effort on the support to the full tolerance, at the same final time."""
    task, answer = offer.task, offer.answer
    support = support_of(task, answer.controls[0])[None]
    ended = polish(task, task.from_controls(answer.controls), support, answer.sign, method)
    tried = ledger.offer(task, ended, "support", exact=bool(support.any()))
    return tried if cheaper(tried, offer) else offer


def _exchanged(
    best: Offer, others: Sequence[Mask], rebuild: Rebuild, method: Method, ledger: Ledger
) -> Offer | None:
    weight = np.asarray(best.task.arguments.weight)[:, None]
    groups: dict[float, list[Mask]] = {}
    changed = _changed(best.task, support_of(best.task, best.answer.controls[0]))
    for support in _different([*others, *changed]):
        groups.setdefault(round(float((weight * support).sum()), 9), []).append(support)
    for count in sorted(groups):
        final_time = _worth(count, best, ledger)
        if final_time is None:
            continue
        task = rebuild(best.task, final_time)
        masks = np.stack(groups[count])
        sign = np.repeat(best.answer.sign, len(masks))
        rest = np.zeros((len(masks), task.intervals, task.size))
        ended = polish(task, rest, masks, sign, method, SCREENING)
        tried = ledger.offer(task, ended, "exchange", exact=True)
        if tried.cost < best.cost:
            return tried
    return None


def _worth(count: float, best: Offer, ledger: Ledger) -> float | None:
    """Final time below which a count would cost less than the best answer, or None."""
    pricing = ledger.pricing
    gain = best.cost - count - 2.0 * TOLERANCE * pricing.weight * best.final_time
    if gain <= 0.0:
        return None
    longest = pricing.longest
    final_time = min(longest, gain / pricing.weight) if pricing.weight > 0.0 else longest
    return final_time if final_time >= pricing.lowest else None


def _changed(task: SparseTask, support: Mask) -> list[Mask]:
    """Supports to try instead of this one."""
    free: Mask = np.asarray(task.arguments.free) > 0
    allowed: Mask = np.any(free, axis=1, keepdims=True) if task.shared else free
    found = [*neighbours(support, allowed), *_grown(support, allowed)]
    if task.shared:
        sizes = range(1, int(allowed.sum()) + 1)
        shapes = [(size - last, last) for size in sizes for last in _halves(size)]
        found += list(bang_off_bang_supports(task, shapes))
    return found


def _different(masks: Iterable[Mask]) -> list[Mask]:
    return list({mask.tobytes(): mask for mask in masks}.values())


def _halves(size: int) -> range:
    least = max(0, (size - _LONGER_BURST) // 2)
    return range(least, min(size, size - least) + 1)


def _grown(support: Mask, allowed: Mask) -> list[Mask]:
    """Supports with one more interval beside an active one, or one beside each."""
    beside = np.zeros_like(support)
    beside[1:] |= support[:-1]
    beside[:-1] |= support[1:]
    beside &= allowed & ~support
    found = []
    for entry in np.argwhere(beside):
        one = support.copy()
        one[tuple(entry)] = True
        found.append(one)
    return [*found, support | beside] if found else []
