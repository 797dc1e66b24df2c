"""Attitudes by two directions, beside SciPy's solution of Wahba's problem."""

import jax
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxatt.attitude import quaternion
from jaxatt.attitude.alignment import align

RNG = np.random.default_rng(2911)


def units(*shape):
    v = RNG.normal(size=(*shape, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def test_the_first_axis_is_aligned_and_the_second_as_near_as_can_be():
    body, direction, second_body, second = units(4, 500)
    scale = RNG.uniform(1e-3, 1e7, (4, 500, 1))
    q = align(body * scale[0], direction * scale[1], second_body * scale[2], second * scale[3])
    np.testing.assert_allclose(quaternion.rotate(q, body), direction, atol=1e-12)
    for k in range(500):
        # The weight of the first direction makes Wahba's answer that of the two vectors.
        pair = np.stack([direction[k], second[k]]), np.stack([body[k], second_body[k]])
        known, _ = Rotation.align_vectors(*pair, weights=[np.inf, 1.0])
        turn = np.abs(known.as_quat(scalar_first=True) @ np.asarray(q[k]))
        assert turn == pytest.approx(1.0, abs=1e-12)


def test_turned_axes_give_the_turned_attitude():
    body, direction, second_body, second, axis = units(5)
    turn = Rotation.from_rotvec(2.0 * axis)
    one = align(body, direction, second_body, second)
    other = align(body, turn.apply(direction), second_body, turn.apply(second))
    both = turn * Rotation.from_quat(np.asarray(one), scalar_first=True)
    np.testing.assert_allclose(
        np.abs(both.as_quat(scalar_first=True) @ np.asarray(other)), 1.0, atol=1e-14
    )


def test_parallel_axes_have_no_answer():
    body, direction, second = units(3)
    for parallel in (
        (body, direction, 2.0 * body, second),
        (body, direction, second, -direction),
    ):
        assert np.isnan(jax.jit(align)(*parallel)).all()
