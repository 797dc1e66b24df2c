"""Quaternion of a rotation vector, and its derivative, against SciPy."""

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from jaxatt.problems.net_power.wheels.turn import increment


def quaternions(vectors):
    return Rotation.from_rotvec(vectors).as_quat(scalar_first=True)


def test_increment_and_its_slope_are_those_of_the_exponential():
    rng = np.random.default_rng(5)
    axes = rng.normal(size=(20, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    vectors = rng.uniform(0.0, 2.0, (20, 1)) * axes
    ways = rng.normal(size=(20, 3))

    def along(vector, way):
        return jax.jvp(lambda v: jnp.stack(increment(tuple(v))), (vector,), (way,))

    found, slopes = jax.jit(jax.vmap(along))(vectors, ways)
    np.testing.assert_allclose(found, quaternions(vectors), atol=1e-12)
    step = 1e-5 * ways
    differences = (quaternions(vectors + step) - quaternions(vectors - step)) / 2e-5
    np.testing.assert_allclose(slopes, differences, atol=1e-8)
