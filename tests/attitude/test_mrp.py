import jax
import numpy as np
from scipy.spatial.transform import Rotation

from jaxatt.attitude import mrp, quaternion

CLOSE = {"rtol": 1e-13, "atol": 4e-15}
from_quaternion = jax.jit(mrp.from_quaternion, static_argnames="short")
to_matrix, to_quaternion = jax.jit(mrp.to_matrix), jax.jit(mrp.to_quaternion)
multiply, shadow_of, switch = jax.jit(mrp.multiply), jax.jit(mrp.shadow), jax.jit(mrp.switch)


def test_short_set_agrees_with_scipy(attitudes):
    sigma = from_quaternion(attitudes)
    clear = np.abs(attitudes[:, 0]) > 1e-9
    expected = Rotation.from_quat(attitudes[clear], scalar_first=True).as_mrp()
    np.testing.assert_allclose(sigma[clear], expected, **CLOSE)
    assert np.all(np.linalg.norm(sigma, axis=1) <= 1 + 1e-15)
    np.testing.assert_allclose(to_matrix(sigma), jax.jit(quaternion.to_matrix)(attitudes), **CLOSE)


def test_signed_set_gives_the_quaternion_back_sign_included(attitudes):
    """Relative to the quarter-angle tangent, even where sigma is 1e12 long."""
    sigma = from_quaternion(attitudes, short=False)
    half_sine = np.hypot(np.hypot(attitudes[:, 1], attitudes[:, 2]), attitudes[:, 3])
    clear = (attitudes[:, 0] > 0) | (half_sine > 1e-150)
    back = to_quaternion(sigma)
    np.testing.assert_allclose(back[clear], attitudes[clear], rtol=1e-12, atol=4e-15)
    length = np.hypot(np.hypot(sigma[:, 0], sigma[:, 1]), sigma[:, 2])
    # tan(angle / 4) by half angles, as the angle itself rounds to 360 degrees.
    expected = np.where(
        attitudes[:, 0] > 0,
        half_sine / (1 + np.abs(attitudes[:, 0])),
        (1 - attitudes[:, 0]) / np.maximum(half_sine, 1e-160),
    )
    np.testing.assert_allclose(length[clear], expected[clear], rtol=1e-13)


def test_shadow_is_the_other_set_of_the_same_attitude(attitudes):
    sigma = from_quaternion(attitudes)
    shadow = shadow_of(sigma)
    length = np.linalg.norm(sigma, axis=1)
    inside, clear = length < 1 - 1e-12, length > 1e-13
    np.testing.assert_allclose(to_matrix(shadow)[clear], to_matrix(sigma)[clear], **CLOSE)
    np.testing.assert_allclose(shadow_of(shadow)[clear], sigma[clear], **CLOSE)
    np.testing.assert_array_equal(switch(sigma)[inside], sigma[inside])
    inside &= clear
    np.testing.assert_allclose(switch(shadow)[inside], sigma[inside], **CLOSE)


def test_products_compose_rotations(attitudes):
    sigma = np.array(from_quaternion(attitudes))
    sigma[::2] = from_quaternion(attitudes, short=False)[::2]
    sigma[np.linalg.norm(sigma, axis=1) > 1e6] = 0.5
    other = np.roll(sigma, 11, axis=0)
    product = multiply(sigma, other)
    assert np.all(np.linalg.norm(product, axis=1) <= 1 + 1e-15)
    expected = np.asarray(to_matrix(sigma)) @ np.asarray(to_matrix(other))
    np.testing.assert_allclose(to_matrix(product), expected, **CLOSE)


def test_derivative_matches_the_quaternion_kinematics():
    rng = np.random.default_rng(6)
    sigma, omega = 2 * rng.normal(size=(50, 3)), rng.normal(size=(50, 3))

    @jax.jit
    def both(sigma, omega):
        q, moved = jax.jvp(mrp.to_quaternion, (sigma,), (mrp.derivative(sigma, omega),))
        return moved, quaternion.derivative(q, omega)

    np.testing.assert_allclose(*both(sigma, omega), rtol=1e-12, atol=1e-14)
