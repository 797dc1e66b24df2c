import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from jaxatt.attitude import quaternion

CLOSE = {"rtol": 1e-13, "atol": 4e-15}
exp, log = jax.jit(quaternion.from_rotation_vector), jax.jit(quaternion.to_rotation_vector)
to_matrix, from_matrix = jax.jit(quaternion.to_matrix), jax.jit(quaternion.from_matrix)
multiply, normalize = jax.jit(quaternion.multiply), jax.jit(quaternion.normalize)
random = jax.jit(quaternion.random, static_argnums=1)


def scipy_rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


def test_matrix_agrees_with_scipy(attitudes):
    expected = scipy_rotation(attitudes).as_matrix()
    np.testing.assert_allclose(to_matrix(attitudes), expected, **CLOSE)


def test_matrix_comes_back_from_its_quaternion(attitudes):
    matrix = scipy_rotation(attitudes).as_matrix()
    q = from_matrix(matrix)
    assert np.all(q[:, 0] >= 0.0)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(to_matrix(q), matrix, **CLOSE)


def test_from_matrix_inverts_to_matrix_with_its_derivatives():
    """q -> R -> q is the identity on the sphere, so its tangent map is too, half turns included."""
    q = np.random.default_rng(9).normal(size=(32, 4))
    q *= np.sign(q[:, :1])
    q[:8, 0] = 0.0
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    tangent = np.random.default_rng(3).normal(size=q.shape)
    tangent -= np.sum(tangent * q, axis=1, keepdims=True) * q

    @jax.jit
    def there_and_back(q, dq):
        return jax.jvp(lambda q: from_matrix(to_matrix(q)), (q,), (dq,))

    back, moved = there_and_back(q, tangent)
    # A half turn may come back as its negative.
    sign = np.sign(np.sum(back * q, axis=1, keepdims=True))
    np.testing.assert_allclose(back * sign, q, **CLOSE)
    np.testing.assert_allclose(moved * sign, tangent, rtol=1e-12, atol=1e-13)


def test_products_compose_rotations(attitudes):
    q1, q2 = attitudes, np.roll(attitudes, 17, axis=0)
    matrices = [scipy_rotation(q).as_matrix() for q in (q1, q2)]
    product = multiply(q1, q2)
    np.testing.assert_allclose(to_matrix(product), matrices[0] @ matrices[1], **CLOSE)
    back = multiply(quaternion.conjugate(q1), product)
    np.testing.assert_allclose(back, q2, **CLOSE)


@pytest.mark.parametrize(("q_shape", "v_shape"), [((), ()), ((), (5,)), ((4, 1), (5,))])
def test_rotation_broadcasts_and_inverts(q_shape, v_shape):
    q = random(jax.random.key(0), q_shape)
    v = np.random.default_rng(2).normal(size=(*v_shape, 3))
    expected = np.einsum("...ij,...j->...i", to_matrix(q), v)
    rotated = jax.jit(quaternion.rotate)(q, v)
    np.testing.assert_allclose(rotated, expected, **CLOSE)
    np.testing.assert_allclose(
        jax.jit(quaternion.rotate_inverse)(q, rotated), np.broadcast_to(v, expected.shape), **CLOSE
    )


def test_derivative_is_the_tangent_of_a_body_axis_turn(attitudes):
    omega = np.random.default_rng(4).normal(size=(len(attitudes), 3))

    @jax.jit
    def turned(q, omega):
        def at(t):
            return multiply(q, quaternion.from_rotation_vector(omega * t))

        return jax.jvp(at, (0.0,), (1.0,))[1]

    expected = jax.vmap(turned)(attitudes, omega)
    np.testing.assert_allclose(jax.jit(quaternion.derivative)(attitudes, omega), expected, **CLOSE)


def test_rotation_vectors_keep_the_sign_of_the_quaternion(attitudes):
    vectors = log(attitudes)
    np.testing.assert_allclose(exp(vectors), attitudes, **CLOSE)
    short = attitudes[:, 0] > 0
    expected = scipy_rotation(attitudes[short]).as_rotvec()
    np.testing.assert_allclose(vectors[short], expected, **CLOSE)
    assert np.all(np.linalg.norm(vectors[~short], axis=1) >= np.pi * (1 - 1e-15))


@settings(deadline=None, max_examples=200)
@given(
    angle=st.floats(1e-150, 2 * np.pi - 1e-3),
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 1e-3),
)
def test_log_inverts_exp_at_every_scale(angle, axis):
    vector = angle * np.array(axis) / np.linalg.norm(axis)
    # Towards a full turn the axis is what is left of sin(angle / 2).
    tolerance = 1e-15 * angle / min(1.0, np.sin(angle / 2) / angle)
    np.testing.assert_allclose(log(exp(vector)), vector, rtol=0, atol=4 * tolerance)


def test_exp_after_log_projects_on_the_sphere_to_first_order(attitudes):
    """log ignores the norm, so the Jacobian of exp(log(q)) at |q| = 1 is I - q q'."""
    q = attitudes[~((attitudes[:, 0] < 0) & (np.linalg.norm(attitudes[:, 1:], axis=1) < 1e-3))]
    jacobian = jax.jit(jax.vmap(jax.jacrev(lambda q: exp(log(q)))))(q)
    expected = np.eye(4) - q[:, :, None] * q[:, None, :]
    np.testing.assert_allclose(jacobian, expected, rtol=0, atol=2e-12)


def test_full_turn_takes_the_x_axis():
    np.testing.assert_allclose(log(np.array([-1.0, 0, 0, 0])), [2 * np.pi, 0, 0])


def test_axis_angle_ignores_the_length_of_the_axis():
    rng = np.random.default_rng(5)
    axis, angle = rng.normal(size=(6, 1, 3)), rng.uniform(-9, 9, size=5)
    unit = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    expected = exp(unit * angle[:, None])
    np.testing.assert_allclose(jax.jit(quaternion.from_axis_angle)(axis, angle), expected, **CLOSE)
    np.testing.assert_array_equal(
        jax.jit(quaternion.from_axis_angle)(np.zeros(3), 1.0), [1.0, 0, 0, 0]
    )


def test_slerp_agrees_with_scipy_and_takes_the_short_way():
    q0 = random(jax.random.key(8), (6,))
    q1 = random(jax.random.key(9), (6,))
    fraction = np.linspace(0, 1, 5)
    path = to_matrix(jax.jit(quaternion.slerp)(q0[:, None], q1[:, None], fraction))
    for k in range(6):
        expected = Slerp([0, 1], scipy_rotation(np.stack([q0[k], q1[k]])))(fraction)
        np.testing.assert_allclose(path[k], expected.as_matrix(), rtol=0, atol=1e-14)


def test_normalize_and_canonical_keep_the_attitude(attitudes):
    scaled = attitudes * np.geomspace(1e-100, 1e100, len(attitudes))[:, None]
    q = normalize(scaled)
    np.testing.assert_allclose(q, attitudes, **CLOSE)
    chosen = quaternion.canonical(q)
    assert np.all(chosen[:, 0] >= 0)
    np.testing.assert_array_equal(np.abs(chosen), np.abs(q))
    np.testing.assert_array_equal(normalize(np.zeros(4)), quaternion.identity())


def test_random_attitudes_are_uniform():
    matrices = np.asarray(to_matrix(random(jax.random.key(1), (20000,))))
    # Every entry of a uniform rotation has mean 0 and variance 1/3; its square has sd 0.298.
    assert np.max(np.abs(matrices.mean(0))) < 5 * np.sqrt(1 / 3 / 20000)
    assert np.max(np.abs((matrices**2).mean(0) - 1 / 3)) < 5 * 0.298 / np.sqrt(20000)
