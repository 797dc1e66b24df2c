import jax
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from jaxatt.attitude import euler, quaternion

to_matrix, from_matrix = jax.jit(euler.to_matrix), jax.jit(euler.from_matrix)
turn = st.floats(-np.pi, np.pi)


def test_agrees_with_scipy():
    angles = np.random.default_rng(0).uniform(-7, 7, size=(4, 25, 3))
    expected = Rotation.from_euler("ZYX", angles.reshape(-1, 3)[:, ::-1]).as_matrix()
    expected = expected.reshape(4, 25, 3, 3)
    np.testing.assert_allclose(to_matrix(angles), expected, atol=2e-15)
    by_quaternion = jax.jit(lambda x: quaternion.to_matrix(euler.to_quaternion(x)))(angles)
    np.testing.assert_allclose(by_quaternion, expected, atol=2e-15)


@settings(deadline=None, max_examples=200)
@given(phi=turn, theta=st.floats(-1.5, 1.5), psi=turn)
def test_angles_come_back_away_from_gimbal_lock(phi, theta, psi):
    angles = np.array([phi, theta, psi])
    difference = np.asarray(from_matrix(to_matrix(angles))) - angles
    np.testing.assert_allclose(np.sin(difference / 2), 0.0, atol=1e-14)


@settings(deadline=None, max_examples=200)
@given(phi=turn, psi=turn, side=st.sampled_from([-1, 1]), power=st.floats(-20, -1))
def test_matrix_comes_back_at_and_near_gimbal_lock(phi, psi, side, power):
    matrix = to_matrix(np.array([phi, side * (np.pi / 2 - 10.0**power), psi]))
    angles = from_matrix(matrix)
    np.testing.assert_allclose(to_matrix(angles), matrix, rtol=0, atol=5e-15)
    assert np.abs(angles[1]) <= np.pi / 2


def test_roll_is_zero_at_gimbal_lock():
    half = np.sqrt(0.5)
    q = quaternion.multiply(
        np.array([half, 0, half, 0]), np.array([np.cos(0.2), np.sin(0.2), 0, 0])
    )
    np.testing.assert_allclose(jax.jit(euler.from_quaternion)(q), [0, np.pi / 2, -0.4], atol=1e-15)


def test_every_attitude_has_angles(attitudes):
    angles = jax.jit(euler.from_quaternion)(attitudes)
    expected = Rotation.from_quat(attitudes, scalar_first=True).as_matrix()
    np.testing.assert_allclose(to_matrix(angles), expected, atol=5e-15)
