"""Neighbours and mergers of a support: complete, inside what is allowed, never twice the same."""

import itertools

import numpy as np
import pytest

from jaxatt.optimize.reweighting.support import mergers, neighbours


def brute_force(support, allowed, far):
    """All supports with one entry dropped or moved within its column, one row only if not far."""
    found = set()
    for k, g in zip(*np.nonzero(support), strict=True):
        dropped = support.copy()
        dropped[k, g] = False
        if dropped.any():
            found.add(dropped.tobytes())
        for place in range(len(support)):
            near = far or abs(place - k) == 1
            if near and allowed[place, g] and not support[place, g]:
                moved = dropped.copy()
                moved[place, g] = True
                found.add(moved.tobytes())
    return found


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(("intervals", "groups"), [(9, 1), (6, 3)])
def test_neighbours_are_those_of_brute_force(seed, intervals, groups):
    rng = np.random.default_rng(seed)
    allowed = rng.random((intervals, groups)) < 0.7
    support = allowed & (rng.random((intervals, groups)) < 0.1 + 0.07 * seed)
    before = support.copy()
    found = neighbours(support, allowed)
    np.testing.assert_array_equal(support, before)
    keys = [each.tobytes() for each in found]
    assert len(keys) == len(set(keys))
    assert set(keys) == brute_force(support, allowed, far=support.sum() <= 6)
    for each in found:
        assert not (each & ~allowed).any()
        assert each.any()
        assert each.sum() - support.sum() in (0, -1)


def test_repeated_drops_reach_every_smaller_support():
    support = np.array([[True], [True], [True], [False]])
    reach, frontier = set(), [support]
    while frontier:
        here = frontier.pop()
        for each in neighbours(here, np.ones_like(support)):
            if each.tobytes() not in reach:
                reach.add(each.tobytes())
                frontier.append(each)
    expected = sum(1 for size in (1, 2, 3) for _ in itertools.combinations(range(4), size))
    assert len(reach) == expected


def test_nothing_active_has_no_neighbours():
    assert neighbours(np.zeros((5, 1), bool), np.ones((5, 1), bool)) == []


def test_a_single_active_entry_is_never_dropped():
    support = np.zeros((5, 1), bool)
    support[2] = True
    found = neighbours(support, np.ones_like(support))
    assert [int(np.flatnonzero(each)[0]) for each in found] == [0, 1, 3, 4]


@pytest.mark.parametrize(("intervals", "groups"), [(8, 1), (5, 3)])
def test_mergers_are_those_of_brute_force(intervals, groups):
    rng = np.random.default_rng(intervals)
    for _ in range(20):
        allowed = rng.random((intervals, groups)) < 0.8
        support = allowed & (rng.random((intervals, groups)) < 0.4)
        expected = set()
        for one, other in itertools.combinations(np.argwhere(support), 2):
            for place in np.argwhere(allowed & ~support):
                merged = support.copy()
                merged[*one] = merged[*other] = False
                merged[*place] = True
                expected.add(merged.tobytes())
        every = [each.tobytes() for each in mergers(support, allowed, 10_000)]
        assert len(every) == len(expected) and set(every) == expected
        some = [each.tobytes() for each in mergers(support, allowed, 7)]
        assert len(some) == min(7, len(every)) and set(some) <= expected
