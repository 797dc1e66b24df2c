"""Refilled chunks against one lane at a time."""

import numpy as np
import pytest

from jaxatt.multistart.refilling import refilling


def countdown(seen=None):
    """Lanes that are a number, and end when they have been halved below one."""

    def advance(lanes, states, fresh):
        left, passes = states
        left = np.where(fresh, lanes, left)
        passes = np.where(fresh, 0, passes)
        going = left >= 1.0
        if seen is not None:
            seen.append((int(going.sum()), int(fresh.sum())))
        left, passes = np.where(going, left / 2.0, left), passes + going
        return (left, passes), {"left": left, "passes": passes}, left >= 1.0

    return advance


def expected(lanes):
    passes = np.where(lanes < 1.0, 0, np.floor(np.log2(np.maximum(lanes, 1.0))) + 1).astype(int)
    return lanes / 2.0**passes, passes


@pytest.mark.parametrize("count", [1, 7, 8, 9, 100])
def test_every_lane_ends_as_if_alone(count):
    lanes = 2.0 ** np.random.default_rng(count).uniform(-1.0, 12.0, count)
    told = []
    empty = (np.zeros(8), np.zeros(8, int))
    found = refilling(countdown(), lanes, empty, 8, told.append)
    left, passes = expected(lanes)
    np.testing.assert_array_equal(found["left"], left)
    np.testing.assert_array_equal(found["passes"], passes)
    assert told[0] == 0
    assert sum(told) == count


def test_the_slowest_lane_does_not_rule():
    """Every eighth lane takes 30 passes, the others 2."""
    lanes = np.where(np.arange(800) % 8 == 0, 2.0**29, 2.0)
    seen = []
    refilling(countdown(seen), lanes, (np.zeros(8), np.zeros(8, int)), 8)
    assert sum(going for going, _ in seen) == expected(lanes)[1].sum() == 100 * 30 + 700 * 2
    assert sum(fresh for _, fresh in seen) == len(lanes)
    # Full rows would take 550 calls; chunks that wait for their slowest lane, 3000.
    assert len(seen) <= 700


def test_a_lane_that_is_not_a_number_leaves_the_others_as_they_are():
    lanes = 2.0 ** np.random.default_rng(5).uniform(0.0, 8.0, 40)
    empty = (np.zeros(8), np.zeros(8, int))
    without = refilling(countdown(), lanes, empty, 8)
    broken = lanes.copy()
    broken[3] = np.nan
    found = refilling(countdown(), broken, empty, 8)
    others = np.arange(40) != 3
    np.testing.assert_array_equal(found["left"][others], without["left"][others])
    assert np.isnan(found["left"][3])


def test_what_goes_wrong_in_a_chunk_is_raised():
    def advance(lanes, states, fresh):
        raise FloatingPointError("no")

    with pytest.raises(FloatingPointError):
        refilling(advance, np.ones(3), (np.zeros(8),), 8)
