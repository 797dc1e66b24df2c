"""Quaternions of many starts at once on the host, in NumPy."""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.host_vectors import cross
from jaxatt.runtime.arrays import Floats


def product(p: Floats, q: Floats) -> Floats:
    """Quaternion product (..., 4) of quaternions that broadcast."""
    u, v = p[..., 1:], q[..., 1:]
    w = p[..., :1] * q[..., :1] - np.sum(u * v, axis=-1, keepdims=True)
    return np.concatenate([w, p[..., :1] * v + q[..., :1] * u + cross(u, v)], axis=-1)


def conjugate(q: Floats) -> Floats:
    """Conjugate (..., 4)."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def exponential(turn: Floats) -> Floats:
    """Quaternion (..., 4) of a rotation vector (..., 3) [rad]."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * turn], -1)


def continuous(q: Floats) -> Floats:
    """Attitudes (..., M, 4) along a way, with signs that do not jump."""
    same = np.where(np.sum(q[..., 1:, :] * q[..., :-1, :], axis=-1) < 0.0, -1.0, 1.0)
    signs = np.cumprod(same, axis=-1)[..., None]
    return np.concatenate([q[..., :1, :], signs * q[..., 1:, :]], axis=-2)


def logarithm(q: Floats) -> Floats:
    """Rotation vector (..., 3) [rad] of the shorter turn of a quaternion (..., 4)."""
    q = np.where(q[..., :1] < 0.0, -q, q)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(length, q[..., :1])
    near = length < 1e-12
    return np.where(near, 2.0, angle / np.where(near, 1.0, length)) * q[..., 1:]


def rotated(q: Floats, v: Floats) -> Floats:
    """Vector (..., 3) from body to inertial axes, R(q) v."""
    twice = 2.0 * cross(q[..., 1:], v)
    return v + q[..., :1] * twice + cross(q[..., 1:], twice)
