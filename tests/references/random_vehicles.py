"""Random vehicles, states and surroundings for properties; everything follows from a generator."""

import numpy as np
from references.wheeled_body import Body, Space

MU = 3.986e14


def unit(rng, size):
    v = rng.normal(size=size)
    return v / np.linalg.norm(v)


def inertia(rng, scale=0.1):
    """Inertia of random point masses: positive definite, and the triangle inequality holds."""
    points = rng.normal(size=(20, 3)) * rng.uniform(0.7, 1.3, 3)
    masses = rng.uniform(0.5, 1.5, 20)
    total = sum(
        m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True)
    )
    return scale * total / np.trace(total) * 3.0


def wheel_axes(rng, count):
    """(3, count) unit axes that span space with room to spare."""
    while True:
        axes = rng.normal(size=(3, count))
        axes /= np.linalg.norm(axes, axis=0)
        if np.linalg.svd(axes, compute_uv=False)[-1] > 0.4:
            return axes


def body(rng, count):
    return Body(inertia(rng), wheel_axes(rng, count), rng.uniform(1e-4, 3e-4, count))


def space(rng, gravity_gradient=True, sine_amplitude=2e-4):
    """A low orbit of any orientation, eccentric enough to matter."""
    eccentricity = rng.uniform(0.01, 0.08)
    elements = (7.2e6, eccentricity, *rng.uniform(0.2, 2.8, 1), *rng.uniform(0.0, 6.0, 3))
    return Space(elements, MU, gravity_gradient, sine_amplitude, rng.uniform(0.5, 1.5))
