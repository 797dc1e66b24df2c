"""Rounded corners against the printed formula, and exact ones against NumPy."""

import jax
import numpy as np
import pytest

from jaxatt.attitude.smooth_maximum import magnitude, positive_part

X = np.linspace(-2.0, 2.0, 81)


def printed(a, b, alpha):
    """Kristiansen (2023), eq. (2.11)."""
    return 0.5 * (a + b + np.sqrt((a - b) ** 2 + alpha))


@pytest.mark.parametrize("alpha", [1e-3, 1e-7])
def test_rounded_corners_are_those_printed(alpha):
    np.testing.assert_allclose(positive_part(X, alpha), printed(X, 0.0, alpha), rtol=1e-14)
    np.testing.assert_allclose(magnitude(X, alpha), printed(X, -X, alpha), rtol=1e-14)


def test_exact_corners_to_the_last_bit():
    np.testing.assert_array_equal(positive_part(X), np.maximum(X, 0.0))
    np.testing.assert_array_equal(magnitude(X), np.abs(X))


@pytest.mark.parametrize("alpha", [0.0, 1e-7])
def test_derivatives_stay_finite_at_the_corner(alpha):
    for part in (positive_part, magnitude):
        first = jax.grad(part)(0.0, alpha)
        second = jax.grad(jax.grad(part))(0.0, alpha)
        assert np.isfinite(first) and np.isfinite(second)
    assert jax.grad(positive_part)(0.0, alpha) == 0.5
