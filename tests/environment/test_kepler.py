import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxatt.environment import KeplerianElements, kepler

to_state, from_state = jax.jit(kepler.to_state), jax.jit(kepler.from_state)


def values(elements):
    return np.array([getattr(elements, field.name) for field in dataclasses.fields(elements)])


def test_textbook_orbit():
    """Vallado, Fundamentals of Astrodynamics and Applications, example 2-5."""
    r = 1e3 * np.array([6524.834, 6862.875, 6448.296])
    v = 1e3 * np.array([4.901327, 5.533756, -1.976341])
    elements = values(from_state(r, v))
    expected = np.array([36127.343e3, 0.832853, *np.deg2rad([87.870, 227.898, 53.38, 92.335])])
    last_digit = np.array([1e1, 1e-6, *np.deg2rad([1e-3, 1e-3, 1e-2, 1e-3])])
    np.testing.assert_array_less(np.abs(elements - expected), last_digit)


angle = st.floats(0, 2 * np.pi)
small = st.sampled_from([0.0, 1e-17, 1e-15, 1e-14, 1e-9, 1e-4])


@settings(deadline=None, max_examples=200)
@given(
    a=st.floats(6.6e6, 5e7),
    e=small | st.floats(0, 0.95),
    inclination=small | small.map(lambda x: np.pi - x) | st.floats(0, np.pi),
    raan=angle,
    perigee=angle,
    anomaly=angle,
)
def test_state_comes_back_from_its_elements(a, e, inclination, raan, perigee, anomaly):
    """On circular and equatorial orbits too, where the angles themselves need not come back."""
    given_elements = KeplerianElements(a, e, inclination, raan, perigee, anomaly)
    r, v = to_state(given_elements)
    elements = from_state(r, v)
    found = values(elements)
    # The gap 1 - e is what perigee knows; a rounding there grows with its inverse square.
    tolerance = 1e-14 / (1 - e) ** 2
    r_back, v_back = to_state(elements)
    np.testing.assert_allclose(r_back, r, rtol=0, atol=10 * tolerance * np.linalg.norm(r))
    np.testing.assert_allclose(v_back, v, rtol=0, atol=10 * tolerance * np.linalg.norm(v))
    np.testing.assert_allclose(found[0], a, rtol=tolerance)
    np.testing.assert_allclose(found[1:3], [e, inclination], rtol=0, atol=20 * tolerance)
    if e > 1e-6 and 1e-6 < inclination < np.pi - 1e-6:
        given_angles = np.array([raan, perigee, anomaly])
        np.testing.assert_allclose(np.sin((found[3:] - given_angles) / 2), 0.0, atol=1e-7)


def test_elements_are_a_pytree_that_batches():
    a = np.array([[7e6], [8e6]])
    elements = KeplerianElements(a, 0.01, 1.0, 0.2, 0.3, np.linspace(0, 6, 5))
    r, v = to_state(elements)
    assert r.shape == v.shape == (2, 5, 3)
    back = from_state(r, v)
    assert back.eccentricity.shape == (2, 5)
    one = jax.tree.map(lambda x: x[1, 3], back)
    np.testing.assert_allclose(to_state(one)[0], r[1, 3], rtol=1e-12)


def test_derivatives_are_those_of_an_inverse_and_finite_where_elements_are_undefined():
    """State -> elements -> state is the identity wherever no element is undefined."""
    inclination = np.array([0.0, np.pi, 0.9, 0.0, 1.0])
    e = np.array([0.0, 0.0, 0.0, 0.2, 0.3])
    r, v = to_state(KeplerianElements(7e6, e, inclination, 0.0, 0.0, 0.7))
    x = np.concatenate([r / 7e6, v / 7e3], axis=1)

    def there_and_back(x):
        elements = kepler.from_state(7e6 * x[:3], 7e3 * x[3:])
        r, v = kepler.to_state(elements)
        return jnp.concatenate([r / 7e6, v / 7e3])

    jacobian = np.asarray(jax.jit(jax.vmap(jax.jacrev(there_and_back)))(x))
    assert np.isfinite(jacobian).all()
    # Where an angle is pinned to zero its derivative is missing; elsewhere all six are there.
    np.testing.assert_allclose(jacobian[4], np.eye(6), atol=1e-11)
