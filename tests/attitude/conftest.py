"""Attitudes on which every representation is tried."""

import numpy as np
import pytest

TURNS = [0.0, *(10.0**k for k in (-300, -160, -12, -8, -4, -2)), 0.063, 0.064, 1.0, 2.0, np.pi]


@pytest.fixture(scope="session")
def attitudes() -> np.ndarray:
    """Unit quaternions (n, 4) of both signs: random ones, and ones at and near 0, 180, 360 deg."""
    rng = np.random.default_rng(7)
    spread = rng.normal(size=(64, 4))
    angles = np.concatenate([TURNS, np.pi - np.array(TURNS[:-1]), np.pi + np.array(TURNS)])
    axes = np.concatenate([rng.normal(size=(8, 3)), np.eye(3), -np.eye(3), [[1, 1, 0], [0, -1, 1]]])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    half, axis = np.meshgrid(angles / 2, np.arange(len(axes)), indexing="ij")
    half, axis = half.ravel(), axes[axis.ravel()]
    near = np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)
    exact_half_turns = np.concatenate([np.zeros((len(axes), 1)), axes], axis=1)
    every = np.concatenate([spread, near, -near, exact_half_turns])
    return every / np.linalg.norm(every, axis=1, keepdims=True)
