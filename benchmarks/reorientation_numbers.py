"""The reorientations of the comparison with IPOPT: numbers, and the paper's random paths.

The numbers are typed in here a second time, from the source and not from the package's scenarios,
so that an error in either shows as a difference between the two sides.

Source: *Sensor-based optimal spacecraft attitude reorientation control by momentum exchange*,
Sensors and Materials 32(5), 2020, sections 4 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

HALF, ROOT = 0.5, np.sqrt(0.5)
AXES = np.array([[1, 0, 0, HALF, -HALF], [0, 1, 0, ROOT, ROOT], [0, 0, 1, HALF, -HALF]], float)
"""Columns are wheel axes; the fourth and fifth lost their roots in print."""

PRINTED_SIGMA = np.array([0.1582, 0.0657, 0.2740])
STATED_AXIS, STATED_ANGLE = np.array([0.4896, 0.2032, 0.8480]), 2.5
"""[rad]; the printed sigma is that of half this angle."""


@dataclass(frozen=True, eq=False)
class Turn:
    """A turn from rest at sigma = 0 to rest, without momentum, so that the rate is linear.

    acceleration : (3, b) [1/(kg m^2)], angular acceleration of a unit of each torque.
    allocation : (b, 3) [kg m^2], least torques for an angular acceleration.
    limit : [N m], of every torque.  sigma : (3,), MRP of the target.
    intervals : N.  weight : [1/(N m)^2], rho.
    """

    acceleration: Floats
    allocation: Floats
    limit: float
    sigma: Floats
    intervals: int
    weight: float

    @property
    def torques(self) -> int:
        """Number of torques b."""
        return self.acceleration.shape[1]


def wheeled_turn(wheels: int, sigma: Floats, weight: float = 0.01, intervals: int = 35) -> Turn:
    """The paper's spacecraft with 3, 4 or 5 wheels; equation (1) with h = 0."""
    axes = AXES[:, :wheels]
    inertia = np.diag([86.215, 85.070, 133.565]) - 0.05 * axes @ axes.T
    return Turn(
        acceleration=-np.linalg.solve(inertia, axes),
        allocation=-np.linalg.pinv(axes) @ inertia,
        limit=0.55,
        sigma=sigma,
        intervals=intervals,
        weight=weight,
    )


def case(name: str) -> Turn:
    """A turn by the name of its scenario.  Raises ValueError where there is none of that name."""
    if name == "minimum-time-180":
        half_turn = np.array([0.0, 0.0, 1.0])
        return Turn(np.eye(3), np.eye(3), 1.0, half_turn, intervals=60, weight=0.0)
    kind, stated = name.removesuffix("-2.5rad"), name.endswith("-2.5rad")
    if kind not in ("mrp-k3", "mrp-k4", "mrp-k5"):
        raise ValueError(f"case = {name!r}: mrp-k3, mrp-k4, mrp-k5, each also with -2.5rad")
    axis = STATED_AXIS / np.linalg.norm(STATED_AXIS)
    sigma = np.tan(STATED_ANGLE / 4) * axis if stated else PRINTED_SIGMA
    return wheeled_turn(int(kind[-1]), sigma)


def rates(sigma: Floats, velocity: Floats) -> Floats:
    """Body rates (n, 3) [rad/s] of MRPs (n, 3) that change by velocity (n, 3) [1/s].

    G(sigma)^-1 = 16 G(sigma)' / (1 + |sigma|^2)^2 with G of equation (5).
    """
    squared = np.sum(sigma**2, axis=1, keepdims=True)
    transposed = (
        (1 - squared) * velocity
        - 2 * np.cross(sigma, velocity)
        + 2 * np.sum(sigma * velocity, axis=1, keepdims=True) * sigma
    )
    return 4 * transposed / (1 + squared) ** 2


@dataclass(frozen=True, eq=False)
class Start:
    """states (N + 1, 6), sigma and rate [rad/s]; torques (N, b) [N m]; step [s]."""

    states: Floats
    torques: Floats
    step: float


def random_path(turn: Turn, seed: int, index: int) -> Start:
    """A random feasible start: the path (27), inverse dynamics, the step raised until it fits.

    Without momentum the torques of a path scale with 1 / step^2, so the step needs no search.  A
    half turn about a symmetry axis is no start for a search: nothing pushes it off that axis,
    so there the torques get a tenth of the limit at random.
    """
    random = np.random.default_rng([seed, index])
    n = turn.intervals
    share = np.r_[0.0, 0.0, random.uniform(size=n - 2), 1.0, 1.0]
    sigma = share[:, None] * turn.sigma
    rate = rates(sigma[:-1], np.diff(sigma, axis=0))
    torques = np.diff(rate, axis=0) @ turn.allocation.T
    step = float(np.sqrt(np.abs(torques).max() / turn.limit))
    torques = torques / step**2
    if turn.weight == 0.0:
        torques = torques + 0.1 * turn.limit * random.uniform(-1.0, 1.0, torques.shape)
    return Start(np.column_stack([sigma[:-1], rate / step]), torques, step)
