"""Cones that fill others up to a shared number take no part in anything."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.problems.hands_off.slew.pointing_path import node_margins
from jaxatt.problems.pointing.cones import KEEP_IN, KEEP_OUT, PointingLimits, PointingPath
from jaxatt.problems.pointing.spare_cones import spare_cones, with_spare_cones


def unit(rng, *shape):
    found = rng.normal(size=shape)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


@pytest.mark.parametrize("count", [1, 3, 4, 5])
@pytest.mark.parametrize("rates", [0, 3])
def test_spare_cones_are_satisfied_by_every_motion_and_change_no_other_row(count, rates):
    rng = np.random.default_rng(10 * count + rates)
    limits = PointingLimits(
        unit(rng, count, 3),
        np.cos(rng.uniform(0.1, 3.0, count)),
        rng.choice([KEEP_IN, KEEP_OUT], count),
        rng.uniform(0.01, 0.1, rates),
    )
    path = PointingPath(limits, unit(rng, 2, count, 3))
    filled = with_spare_cones(path, spare_cones(count))
    assert filled.limits.count == count + spare_cones(count)
    assert filled.limits.count % 4 == 0 and spare_cones(count) < 4

    def rows(motion, path):
        return node_margins(
            motion[:4], motion[4:], path.directions[1], jnp.asarray(2.0), path.limits
        )

    both = jax.jit(lambda motion, path: (rows(motion, path), jax.jacfwd(rows)(motion, path)))
    for _ in range(20):
        motion = np.concatenate([unit(rng, 4), rng.normal(size=3)])
        (before, slope), (after, slopes) = both(motion, path), both(motion, filled)
        spare = slice(count, filled.limits.count)
        assert np.all(after[spare] > 0.1)
        assert not np.any(slopes[spare])
        np.testing.assert_allclose(np.delete(after, range(*spare.indices(99))), before, atol=1e-14)
        np.testing.assert_allclose(
            np.delete(slopes, range(*spare.indices(99)), 0), slope, atol=1e-13
        )
