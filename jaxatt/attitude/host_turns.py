"""Quaternions on the host, for paths that begin a search: nothing to compile for their shapes."""

from __future__ import annotations

import numpy as np

from jaxatt.runtime.arrays import Floats


def product(p: Floats, q: Floats) -> Floats:
    """Product of quaternions (..., 4)."""
    w, u, x, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    scalar = w * x - np.sum(u * v, axis=-1, keepdims=True)
    return np.asarray(np.concatenate([scalar, w * v + x * u + np.cross(u, v)], axis=-1))


def conjugate(q: Floats) -> Floats:
    """Inverse of unit quaternions (..., 4)."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def turned_by(vector: Floats) -> Floats:
    """Quaternions (..., 4) of rotation vectors (..., 3) [rad]."""
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    scale = 0.5 * np.sinc(half / np.pi)
    return np.asarray(np.concatenate([np.cos(half), scale * vector], axis=-1))


def turn_of(q: Floats) -> Floats:
    """Rotation vectors (..., 3) [rad] of quaternions, of 0 to 2 pi: beyond pi where q[0] < 0."""
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(length, q[..., :1])
    return np.asarray(q[..., 1:] * angle / np.maximum(length, 1e-300))


def to_body(q: Floats, vector: Floats) -> Floats:
    """Components after a turn q (..., 4) of what has the components `vector` before it."""
    twice = 2.0 * np.cross(q[..., 1:], vector)
    return np.asarray(vector - q[..., :1] * twice + np.cross(q[..., 1:], twice))
