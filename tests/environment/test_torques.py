import jax
import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.environment import (
    MU_EARTH,
    KeplerianElements,
    frames,
    gravity_gradient_torque,
    kepler,
    sinusoidal_torque,
)

gravity = jax.jit(gravity_gradient_torque)


def test_gravity_gradient_is_the_moment_of_gravity_on_point_masses():
    """Newton's law on each of a cloud of masses 50 m wide, summed about its centre."""
    rng = np.random.default_rng(21)
    mass = rng.uniform(1, 5, 12)
    place_b = rng.normal(size=(12, 3)) * [50, 20, 10]
    place_b -= mass @ place_b / mass.sum()
    inertia = np.einsum("k,kij->ij", mass, np.eye(3) * np.sum(place_b**2, 1)[:, None, None])
    inertia -= np.einsum("k,ki,kj->ij", mass, place_b, place_b)

    q_ob = np.random.default_rng(2).normal(size=(6, 4))
    q_ob /= np.linalg.norm(q_ob, axis=1, keepdims=True)
    anomaly = np.linspace(0, 5, 6)
    elements = KeplerianElements(9e6, 0.2, 1.0, 0.4, 0.7, anomaly)

    @jax.jit
    def place(elements, q_ob):
        r_i, v_i = kepler.to_state(elements)
        return r_i, quaternion.multiply(frames.quaternion_io(r_i, v_i), q_ob)

    r_i, q_ib = place(elements, q_ob)
    rotation = np.asarray(jax.jit(quaternion.to_matrix)(q_ib))
    place_i = np.einsum("nij,kj->nki", rotation, place_b)
    at = np.asarray(r_i)[:, None] + place_i
    force = -MU_EARTH * mass[:, None] * at / np.linalg.norm(at, axis=-1, keepdims=True) ** 3
    expected = np.einsum("nji,nj->ni", rotation, np.sum(np.cross(place_i, force), axis=1))

    torque = gravity(q_ob, r_i, inertia)
    size = np.max(np.abs(expected))
    np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-4 * size)
    halved = gravity(q_ob, r_i, inertia, MU_EARTH / 2)
    np.testing.assert_allclose(halved, torque / 2, rtol=1e-14)


def test_gravity_gradient_vanishes_with_a_principal_axis_to_nadir():
    q_ob = np.array([[1.0, 0, 0, 0], [0.5, 0.5, 0.5, 0.5]])
    inertia = np.array([np.diag([1.0, 2.0, 3.0]), np.diag([5.0, 1.0, 4.0])])[:, None]
    torque = gravity(q_ob, np.array([7e6, 0, 0]), inertia)
    assert torque.shape == (2, 2, 3)
    np.testing.assert_array_equal(torque, 0.0)


def test_gravity_gradient_in_single_precision():
    q_ob = np.array([0.1, -0.7, 0.5, 0.5])
    inertia = np.diag([0.05, 0.02, 0.07])
    r_i = np.array([1e6, -6e6, 3e6])
    torque = gravity(*(np.asarray(x, np.float32) for x in (q_ob, r_i, inertia)))
    assert torque.dtype == np.float32
    expected = gravity(q_ob, r_i, inertia)
    size = np.linalg.norm(expected)
    np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-5 * size)


def test_sinusoidal_torque_oscillates_alike_on_each_axis():
    t = np.linspace(0, 70, 6)
    amplitude = np.array([[1e-4], [2e-4]])
    torque = sinusoidal_torque(t, amplitude)
    expected = (amplitude * np.sin(t))[..., None] * np.ones(3)
    np.testing.assert_allclose(torque, expected, rtol=1e-14)
    np.testing.assert_allclose(
        sinusoidal_torque(t, amplitude, 0.5), sinusoidal_torque(t / 2, amplitude)
    )
