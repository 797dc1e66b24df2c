"""Start i is its own: it depends on the seed and on i, on nothing else."""

import numpy as np
import pytest

from jaxatt.problems.hands_off.search.starts import draw

INTERVALS, SIZE = 50, 3


def test_start_i_does_not_depend_on_how_many_there_are():
    few, many = (draw(3, count, INTERVALS, SIZE, 0.3) for count in (5, 64))
    for a, b in zip(few, many, strict=True):
        np.testing.assert_array_equal(a, b[:5])


def test_seeds_reproduce_and_differ():
    first, again, other = (draw(seed, 8, INTERVALS, SIZE, 0.5) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.u, again.u)
    np.testing.assert_array_equal(first.sign, again.sign)
    assert not (first.u == other.u).any()


def test_no_two_starts_are_alike():
    u = draw(0, 64, INTERVALS, SIZE, 0.0).u.reshape(64, -1)
    assert len(np.unique(u, axis=0)) == 64
    correlation = np.corrcoef(u) - np.eye(64)
    assert np.abs(correlation).max() < 0.75  # heavy tails, so not small, but far from one


@pytest.mark.parametrize("probability", [0.0, 0.2, 0.5, 1.0])
def test_the_share_that_goes_the_long_way(probability):
    sign = draw(5, 2000, 2, 1, probability).sign
    assert set(sign) <= {-1.0, 1.0}
    assert abs((sign < 0).mean() - probability) < 0.04
    if probability in (0.0, 1.0):
        assert (sign < 0).mean() == probability


def test_about_half_are_confined_to_the_windows_independently_of_the_way():
    starts = draw(6, 2000, 2, 1, 0.5)
    assert abs(starts.confined.mean() - 0.5) < 0.04
    assert abs(np.corrcoef(starts.confined, starts.sign)[0, 1]) < 0.08


def test_a_guess_comes_first_and_the_rest_are_near_it():
    guess = np.random.default_rng(0).normal(size=(INTERVALS, SIZE))
    guess[10:20] = 0.0
    starts = draw(0, 6, INTERVALS, SIZE, 0.0, guess)
    np.testing.assert_array_equal(starts.u[0], guess)
    assert not starts.u[:, 10:20].any()
    change = starts.u[1:, :10] / guess[None, :10] - 1.0
    assert 0.2 < change.std() < 0.4
    few = draw(0, 2, INTERVALS, SIZE, 0.0, guess)
    np.testing.assert_array_equal(few.u, starts.u[:2])
