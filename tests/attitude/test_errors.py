import jax
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxatt.attitude import errors, quaternion

angle, multiply = jax.jit(errors.angle), jax.jit(quaternion.multiply)
COMMON = np.array([0.1, -0.7, 0.5, 0.5])


smooth_maximum, smooth_abs = jax.jit(errors.smooth_maximum), jax.jit(errors.smooth_abs)


@jax.jit
def turned(q, axis, by):
    return quaternion.multiply(q, quaternion.from_axis_angle(axis, by))


@settings(deadline=None, max_examples=200)
@given(
    by=st.floats(0, np.pi) | st.floats(-16, 0).map(lambda p: 10.0**p),
    supplement=st.booleans(),
    seed=st.integers(0, 2**31),
    sign=st.sampled_from([-1, 1]),
)
def test_angle_is_the_turn_made(by, supplement, seed, sign):
    by = np.pi - by if supplement else by
    rng = np.random.default_rng(seed)
    q_ref, axis = rng.normal(size=4), rng.normal(size=3)
    q_ref /= np.linalg.norm(q_ref)
    q = sign * turned(q_ref, axis, by)
    assert abs(angle(q_ref, q) - by) < 1e-14


def test_measures_ignore_the_sign_and_a_common_turn(attitudes):
    q_ref, q = np.roll(attitudes, 29, axis=0), attitudes
    moved = multiply(COMMON, q_ref), multiply(COMMON, -q)
    for measure in (errors.angle, errors.pseudo_metric, errors.smooth_pseudo_metric):
        np.testing.assert_allclose(
            jax.jit(measure)(*moved), jax.jit(measure)(q_ref, q), rtol=0, atol=3e-15
        )
    expected = 1 - np.cos(np.asarray(angle(q_ref, q)) / 2)
    np.testing.assert_allclose(
        jax.jit(errors.pseudo_metric)(q_ref, q), expected, rtol=0, atol=1e-15
    )


def test_error_quaternion_and_rotation_vector_lead_back(attitudes):
    q_ref, q = np.roll(attitudes, 29, axis=0), attitudes
    error = jax.jit(errors.error_quaternion)(q_ref, q)
    np.testing.assert_allclose(multiply(q_ref, error), q, atol=2e-15)
    vector = jax.jit(errors.rotation_vector)(q_ref, q)
    length = np.linalg.norm(vector, axis=1)
    np.testing.assert_allclose(length, angle(q_ref, q), rtol=1e-14, atol=1e-15)
    arrived = np.asarray(multiply(q_ref, jax.jit(quaternion.from_rotation_vector)(vector)))
    # The same attitude: the outer products q q' agree, whatever the signs.
    np.testing.assert_allclose(
        arrived[:, :, None] * arrived[:, None], q[:, :, None] * q[:, None], atol=2e-15
    )


def test_angle_grows_at_unit_rate_right_up_to_the_kinks():
    by = np.array([1e-100, 1e-15, 1e-8, 1e-3, 1.0, 3.0, np.pi - 1e-3, np.pi - 1e-7])
    axis = np.array([0.36, 0.48, 0.8])

    def from_identity(by):
        return errors.angle(quaternion.identity(), quaternion.from_axis_angle(axis, by))

    np.testing.assert_allclose(jax.jit(jax.vmap(jax.grad(from_identity)))(by), 1.0, atol=1e-8)


@settings(deadline=None, max_examples=100)
@given(x1=st.floats(-10, 10), x2=st.floats(-10, 10), alpha=st.floats(1e-12, 1))
def test_smooth_maximum_lies_just_above_the_maximum(x1, x2, alpha):
    smooth = float(smooth_maximum(x1, x2, alpha))
    assert -1e-15 <= smooth - max(x1, x2) <= np.sqrt(alpha) / 2 + 1e-15
    assert np.isclose(smooth_abs(x1, alpha), np.sqrt(x1**2 + alpha / 4), rtol=1e-14)


def test_smooth_metric_is_stationary_only_by_symmetry_at_half_a_turn():
    """At 180 degrees the smoothed metric is 1 - sqrt(alpha) / 2 with zero slope, not a kink."""
    half_turn = np.array([0.0, 0.6, 0.0, 0.8])

    @jax.jit
    def metric(q, alpha):
        return errors.smooth_pseudo_metric(quaternion.identity(), q, alpha)

    for alpha in (1e-8, 1e-4):
        value, slope = jax.value_and_grad(metric)(half_turn, alpha)
        assert np.isclose(value, 1 - np.sqrt(alpha) / 2, rtol=1e-14)
        np.testing.assert_array_equal(slope, 0.0)
