import jax
import numpy as np

from jaxatt.attitude import quaternion, vectors
from jaxatt.environment import KeplerianElements, frames, kepler, orbit

matrix_io = jax.jit(frames.matrix_io)


def states(shape=(40,)):
    rng = np.random.default_rng(12)
    a, e = rng.uniform(6.8e6, 5e7, shape), rng.uniform(0, 0.9, shape)
    angles = rng.uniform(0, 2 * np.pi, (4, *shape))
    return jax.jit(kepler.to_state)(KeplerianElements(a, e, angles[0] / 2, *angles[1:]))


def test_axes_are_nadir_and_against_the_normal():
    r, v = states((5, 8))
    matrix = np.asarray(matrix_io(r, v))
    np.testing.assert_allclose(
        np.swapaxes(matrix, -1, -2) @ matrix, np.broadcast_to(np.eye(3), matrix.shape), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(matrix), 1.0, rtol=1e-14)
    local_r, local_v = (np.einsum("...ji,...j->...i", matrix, x) for x in (r, v))
    radius, speed = np.linalg.norm(r, axis=-1), np.linalg.norm(v, axis=-1)
    np.testing.assert_allclose(local_r / radius[..., None], np.broadcast_to([0, 0, -1], r.shape),
                               atol=1e-14)  # fmt: skip
    np.testing.assert_allclose(local_v[..., 1] / speed, 0.0, atol=1e-14)
    assert np.all(local_v[..., 0] > 0)


def test_quaternion_is_of_the_same_rotation():
    r, v = states()
    q_io = jax.jit(frames.quaternion_io)(r, v)
    back = jax.jit(quaternion.to_matrix)(q_io)
    np.testing.assert_allclose(back, matrix_io(r, v), atol=3e-15)


def test_rate_is_how_the_axes_turn_along_the_orbit():
    """dR_io/dt = R_io S(omega_io) with omega_io in orbit axes, eccentric orbits included."""
    r, v = states()

    @jax.jit
    def turning(r, v):
        def axes(dt):
            return frames.matrix_io(*orbit.propagate(r, v, dt))

        return jax.jvp(axes, (0.0,), (1.0,))

    matrix, change = turning(r, v)
    omega = jax.jit(frames.omega_io)(r, v)
    expected = np.asarray(matrix) @ np.asarray(jax.jit(vectors.skew)(omega))
    size = np.linalg.norm(omega, axis=-1)[:, None, None]
    np.testing.assert_allclose(change / size, expected / size, atol=1e-12)
    momentum = np.einsum("...ji,...j->...i", matrix, np.cross(r, v))
    literal = momentum / np.sum(np.square(r), -1)[:, None]
    np.testing.assert_allclose(omega, literal, atol=1e-15 * np.max(size))
