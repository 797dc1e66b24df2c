"""Attitudes that point one body axis and leave the roll about it open, on the host."""

from __future__ import annotations

import math

import numpy as np

from jaxatt.attitude.host_turns import conjugate, product, to_body, turned_by
from jaxatt.runtime.arrays import Floats

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_ANY_ROLL = 1e-12
"""Cosine of half the angle off the direction below which all rolls are equally near: opposite."""


def nearest_roll(reference: Floats, boresight: Floats, q: Floats) -> Floats:
    """Attitudes (..., 4) that point as the reference does, rolled to be nearest to q (..., 4).

    The twist of a swing-twist decomposition about the boresight, a unit body axis (3,).  The angle
    from there to q is that between where the boresight points and where it should.
    """
    error = product(conjugate(reference), q)
    along = np.stack([error[..., 0], error[..., 1:] @ boresight], axis=-1)
    size = np.linalg.norm(along, axis=-1, keepdims=True)
    along = np.where(size > _ANY_ROLL, along / np.maximum(size, _ANY_ROLL), [1.0, 0.0])
    return product(reference, np.concatenate([along[..., :1], along[..., 1:] * boresight], axis=-1))


def facing(reference: Floats, rate: Floats, boresight: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Attitudes (..., 4) as `nearest_roll`, and the rate (..., 3) in their body axes.

    rate : (3,), in the body axes of the reference.
    """
    rolled = nearest_roll(reference, boresight, q)
    return rolled, to_body(product(conjugate(reference), rolled), rate)


def spread_rolls(reference: Floats, boresight: Floats, count: int) -> Floats:
    """Attitudes (S, 4) with rolls spread evenly over a turn, the reference first.

    Attitude i depends on i only: the rolls are multiples of the golden section.
    """
    roll = 2.0 * np.pi * np.mod(_GOLDEN * np.arange(count), 1.0)
    return product(reference[None], turned_by(roll[:, None] * boresight))


def across(boresight: Floats) -> Floats:
    """Two unit axes (2, 3) whose product is a given one (3,)."""
    other = np.eye(3)[np.argmin(np.abs(boresight))]
    first = np.cross(other, boresight)
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(boresight, first)])


def roll_angle(reference: Floats, boresight: Floats, q: Floats) -> Floats:
    """Roll (...) [rad] about the boresight from the reference to q (..., 4), of - pi to pi."""
    error = product(conjugate(reference), q)
    angle = 2.0 * np.arctan2(error[..., 1:] @ boresight, error[..., 0])
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle)))
