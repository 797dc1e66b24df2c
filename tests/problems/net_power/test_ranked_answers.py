"""Which of the flown answers is the best, where errors are a constraint and where they cost."""

import numpy as np
import pytest

from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.found import Solved, ranked
from jaxatt.problems.verdict import Verdict


def answers(attitude, score, over):
    """Answers that are so far off [rad], score so much and exceed their limits so much."""
    count, nothing = len(score), np.zeros(len(score))
    solved = Solved(
        torque=np.zeros((count, 2, 3)),
        dipole=None,
        claimed=nothing,
        status=np.full(count, int(Status.CONVERGED)),
        violation=nothing,
        stationarity=nothing,
        iterations=np.ones(count, int),
    )
    verdict = Verdict(
        {"attitude": np.asarray(attitude)}, {"attitude": 0.01}, np.asarray(over), nothing
    )
    return solved, verdict, np.asarray(score)


@pytest.mark.parametrize(
    ("attitude", "score", "over", "reaching", "weighed"),
    [
        # The dearest of all misses; only where that costs is it the best.
        ([0.0, 0.0, 0.5], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0], 1, 2),
        # None reaches: the nearest, or the one that scores most.
        ([0.5, 0.2, 0.3], [3.0, 1.0, 2.0], [0.0, 0.0, 0.0], 1, 0),
        # A limit is a limit in both.
        ([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 1, 1),
        ([0.5, 0.0, 0.0], [np.nan, 1.0, -np.inf], [0.0, 0.0, 0.0], 1, 1),
    ],
)
def test_the_best_reaches_unless_errors_are_weighed(attitude, score, over, reaching, weighed):
    solved, verdict, scores = answers(attitude, score, over)
    for asked, expected in ((False, reaching), (True, weighed)):
        found = ranked(None, solved, None, verdict, scores, 1.0, asked)
        assert found.best == expected
        assert (found.share > 0.0) == (found.minima > 0) == (asked or verdict.reached.any())
