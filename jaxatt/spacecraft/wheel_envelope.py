"""Torques and momenta that a set of wheels can reach: a zonotope, spanned by the wheel axes."""

from __future__ import annotations

import itertools

import numpy as np

from jaxatt.spacecraft.checks import Float64

_PARALLEL = 1e-6
# Below this ratio of singular values the allocation would multiply torques by more than 1e6.
_RANK_TOLERANCE = 1e-6


def envelope_share(axes: Float64, most: Float64, vector: Float64) -> float:
    """Return a torque or momentum as a share of what limits of the wheels allow along it.

    The reachable set is ``{A u, |u_i| <= most_i}``; its faces are parallel to two axes each.

    Parameters
    ----------
    axes : (3, n) array
        Unit spin axes in body components, one column a wheel.
    most : (n,) array
        Largest torque [N m] or momentum [N m s] of each wheel; ``inf`` means no limit.
    vector : (3,) array
        In body components.

    Returns
    -------
    float
        Greater than 1 where it cannot be reached.
    """
    share = 0.0
    for first, second in itertools.combinations(axes.T, 2):
        normal = np.cross(first, second)
        across = np.abs(normal @ axes)
        if across.max() < _PARALLEL:
            continue
        turned = across > _PARALLEL * across.max()
        reach = float(across[turned] @ most[turned])
        share = max(share, abs(float(normal @ vector)) / reach)
    return share


def largest_about_axes(axes: Float64, most: Float64) -> Float64:
    """Return the largest torque or momentum about each body axis alone, the other two zero, (3,).

    Arguments as for `envelope_share`.
    """
    shares = np.array([envelope_share(axes, most, one) for one in np.eye(3)])
    return np.divide(1.0, shares, out=np.full(3, np.inf), where=shares > 0.0)


def spanned_directions(axes: Float64) -> tuple[int, str]:
    """Return how many directions unit axes (3, n) span, and one about which they turn least.

    The direction is in body components, as text.
    """
    if not axes.size:
        return 0, "1, 0, 0"
    left, singular, _ = np.linalg.svd(axes)
    spanned = int((singular >= _RANK_TOLERANCE * singular[0]).sum())
    return spanned, ", ".join(f"{component:.3g}" for component in left[:, 2] + 0.0)
