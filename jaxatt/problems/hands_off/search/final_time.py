"""Search over controls and final time together, with a fixed number of intervals.

Where active intervals are counted, the cost is a staircase in the final time: a count holds down to
the final time at which torque limits bind, plus the price of the time.  So its optimum is the least
final time of some support, and the search is one over supports:

1. A full search at the longest final time, and starts alone at a few shorter ones.
2. The cheapest support is shortened to its least final time, see `least_time`.
3. It is exchanged for others that would cost less.
4. All starts again at the final time found; if they find a cheaper support, once more from 2.

Where the cost is smooth in the final time (L1, the printed costs), a few final times bracket the
optimum and a golden section search narrows it.

That no final time in between does better is not proved: both ways take it that a support which
reaches within limits still does in more time, or that the cost has one valley in the bracket.
Wheel speed limits that did not bind at the longest final time are left to the verdict at others.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from jaxatt.problems.hands_off.search.candidates import Candidates, join, support_of
from jaxatt.problems.hands_off.search.least_time import TOLERANCE, exchange, finish, shorten
from jaxatt.problems.hands_off.search.polish import Method
from jaxatt.problems.hands_off.search.search import Found, chosen, look, search
from jaxatt.problems.hands_off.search.time_cost import (
    Ledger,
    Offer,
    Pricing,
    Rebuild,
    Trial,
    cheaper,
)
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.chunks import Report

Attempt = Callable[[float], tuple[SparseTask, Found]]
"""Final time [s] -> a task and all that a search finds there."""

_SCAN = 8
_SCAN_RATIO = 0.75
_ROWS = 8
"""Supports in one compiled call: of most final times there is one to be tried."""
_ROUNDS = 3
_FEW = 8
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_NARROW = 1e-3
STAGE = "trying final times"


@dataclass(frozen=True)
class Timed:
    """The answer at its final time.

    task, found : at the final time chosen.  cost : with the time's own; infinite if not reached.
    trials : every final time that was tried, in order.
    """

    task: SparseTask
    found: Found
    cost: float
    trials: tuple[Trial, ...]


def search_final_time(
    attempt: Attempt,
    rebuild: Rebuild,
    pricing: Pricing,
    count: int,
    seed: int,
    report: Report | None = None,
) -> Timed:
    """Find the best control and its final time.

    attempt : a full search, made at the longest final time.  rebuild : gives all other tasks.
    count, seed : number of starts and their seed.
    report : called by the host with (stage, number just ended).
    """
    progress = None if report is None else lambda done: report(STAGE, done)
    ledger = Ledger(pricing, progress)
    task, found = attempt(pricing.longest)
    first = ledger.offer(task, _pool(found), "search")
    counts = task.goal.kind != "l1" and task.goal.terminal == "reach"
    find = _by_support if counts else _by_cost
    best = find(first, rebuild, ledger, count, seed)
    if best.final_time != task.final_time:
        task = best.task
        starts = look(task, count, seed)
        found = chosen(task, starts, join(starts, best.answer))
    elif best is not first:
        found = chosen(task, found.starts, join(_pool(found), best.answer))
    return Timed(task, found, best.cost, tuple(ledger.trials))


def _pool(found: Found) -> Candidates:
    return found.best if found.reaching is None else join(found.best, found.reaching)


def _times(pricing: Pricing, most: int) -> list[float]:
    """Final times below the longest, in geometric progression."""
    times = [pricing.longest * _SCAN_RATIO**k for k in range(1, most + 1)]
    return [time for time in times if time > pricing.lowest]


def _by_support(first: Offer, rebuild: Rebuild, ledger: Ledger, count: int, seed: int) -> Offer:
    offers = [first]
    for time in _times(ledger.pricing, _SCAN):
        task = rebuild(first.task, time)
        offers.append(ledger.offer(task, look(task, count, seed), "starts"))
        if np.isfinite(offers[-2].cost) and np.isinf(offers[-1].cost):
            break
    reached = [offer for offer in offers if np.isfinite(offer.cost)]
    if not reached:
        return first
    if ledger.pricing.weight == 0.0:
        return _first_of(reached)
    method = Method("l0", rows=_ROWS)
    others = [support_of(offer.task, offer.answer.controls[0]) for offer in reached]
    best = shorten(_first_of(reached), rebuild, method, ledger)
    best = exchange(best, others, rebuild, method, ledger)
    for _ in range(_ROUNDS):
        task = rebuild(first.task, best.final_time)
        again = ledger.offer(task, look(task, count, seed), "starts")
        if again.cost >= best.cost - TOLERANCE * ledger.pricing.weight * best.final_time:
            break
        best = shorten(again, rebuild, method, ledger)
        best = exchange(best, others, rebuild, method, ledger)
    return finish(best, method, ledger)


def _first_of(offers: list[Offer]) -> Offer:
    best = offers[0]
    for offer in offers[1:]:
        best = offer if cheaper(offer, best) else best
    return best


def _by_cost(first: Offer, rebuild: Rebuild, ledger: Ledger, count: int, seed: int) -> Offer:
    best = first

    def at(time: float) -> Offer:
        nonlocal best
        task = rebuild(first.task, time)
        near = best.answer.controls[0] * (best.final_time / time) ** 2
        guess = near if np.isfinite(best.cost) else None
        found = search(task, min(_FEW, count), seed, guess)
        made = ledger.offer(task, _pool(found), "starts")
        best = made if cheaper(made, best) else best
        return made

    longest, lowest = ledger.pricing.longest, ledger.pricing.lowest
    tried = [first]
    for time in _times(ledger.pricing, _SCAN):
        tried.append(at(time))
        if np.isfinite(tried[-2].cost) and np.isinf(tried[-1].cost):
            break
    if first.task.goal.terminal == "penalty":
        at(lowest)  # where a printed cost that prefers not to move is lowest
    times = sorted({longest, lowest, *(offer.final_time for offer in tried)})
    place = times.index(best.final_time)
    low, high = times[max(place - 1, 0)], times[min(place + 1, len(times) - 1)]
    left, right = _inside(low, high, 1.0 - _GOLDEN), _inside(low, high, _GOLDEN)
    at_left, at_right = at(left), at(right)
    while high - low > _NARROW * high:
        if np.isfinite(at_left.cost) and cheaper(at_left, at_right):
            high, right, at_right = right, left, at_left
            left = _inside(low, high, 1.0 - _GOLDEN)
            at_left = at(left)
        else:
            low, left, at_left = left, right, at_right
            right = _inside(low, high, _GOLDEN)
            at_right = at(right)
    return best


def _inside(low: float, high: float, share: float) -> float:
    return low + share * (high - low)
