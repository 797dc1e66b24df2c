"""A set of reaction wheels in any mounting that spans three directions."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.attitude.vectors import matvec
from jaxatt.spacecraft.checks import FieldError, Float64, brief, finite_array, positive_per_item

Array = jax.Array | Float64

# Rounded axes such as 0.57735 are meant as unit vectors: only a larger deviation earns a note.
_UNIT_TOLERANCE = 1e-5
# Below this ratio of singular values the allocation would multiply torques by more than 1e6.
_RANK_TOLERANCE = 1e-6


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ReactionWheels:
    """Reaction wheels; build them with `reaction_wheels`, which checks the numbers.

    Attributes
    ----------
    axes : (3, n) array
        Unit spin axes in body components, one column a wheel: A of Schaanning (2021), eq. 5.11.
    inertia : (n,) array [kg m^2]
        Inertia of each wheel about its spin axis.
    torque_limit : (n,) array [N m]
        Largest absolute torque of each wheel.
    speed_limit : (n,) array [rad/s]
        Largest absolute speed of each wheel relative to the body; ``inf`` means no limit.
    efficiency : () array
        Mechanical power of a drive as a share of the electrical power that it draws.
    regeneration : () array
        Share of the braking power that the drives recover, between 0 and 1.
    """

    axes: Array
    inertia: Array
    torque_limit: Array
    speed_limit: Array
    efficiency: Array | float = 1.0
    regeneration: Array | float = 0.0

    @property
    def count(self) -> int:
        """Number of wheels."""
        return int(self.axes.shape[-1])

    @property
    def allocation(self) -> Array:
        """Moore-Penrose inverse from body to wheel torque, (n, 3); Schaanning (2021), eq. 2.42.

        The mounting has full row rank, so the pseudo-inverse is ``A' (A A')^-1``: smooth in the
        axes, where one by singular values has no derivative for equal singular values.
        """
        # Plain numbers stay on the host, where nothing has to be compiled.
        axes, library = self.axes, np if isinstance(self.axes, np.ndarray) else jnp
        if self.count == 0:
            return library.zeros((0, 3), axes.dtype)
        gram = axes @ axes.swapaxes(-1, -2)
        allocation: Array = library.linalg.solve(gram, axes).swapaxes(-1, -2)
        return allocation

    @property
    def braking_cost(self) -> Array | float:
        """Electrical power of a drive for each watt that it brakes with, ().

        What is not recovered costs 1 / eta, as much as driving does; what is recovered returns eta.
        """
        return (1.0 - self.regeneration) / self.efficiency - self.regeneration * self.efficiency

    @property
    def spin_inertia_body(self) -> Array:
        """Inertia of the wheels about their axes in body components, A Jw A', (3, 3) [kg m^2]."""
        return (self.axes * self.inertia[..., None, :]) @ self.axes.swapaxes(-1, -2)


def no_wheels() -> ReactionWheels:
    """Wheels of a vehicle that has none."""
    empty = np.zeros(0)
    return ReactionWheels(np.zeros((3, 0)), empty, empty, empty)


def momentum(wheels: ReactionWheels, omega_bw: Any) -> jax.Array:
    """Return the momentum of the wheels relative to the body, A Jw omega_bw.

    Parameters
    ----------
    wheels : ReactionWheels
    omega_bw : (..., n) array [rad/s]
        Wheel speeds relative to the body.

    Returns
    -------
    (..., 3) array [N m s]
        In body components; the wheel term of Schaanning (2021), eq. 4.8.
    """
    return matvec(wheels.axes * jnp.asarray(wheels.inertia)[..., None, :], omega_bw)


def storage_share(wheels: ReactionWheels, stored: Any) -> float:
    """Return a wheel momentum as a share of what the speed limits allow.

    Parameters
    ----------
    wheels : ReactionWheels
    stored : (3,) array_like [N m s]
        Momentum A Jw omega_bw in body components.

    Returns
    -------
    float
        Greater than 1 where no speeds within the limits hold it. The momenta that can be held
        form a zonotope; its faces are parallel to two wheel axes each.
    """
    axes = np.asarray(wheels.axes)
    most = np.asarray(wheels.inertia) * np.asarray(wheels.speed_limit)
    share = 0.0
    for first, second in itertools.combinations(axes.T, 2):
        normal = np.cross(first, second)
        across = np.abs(normal @ axes)
        if across.max() < _RANK_TOLERANCE:
            continue
        turned = across > _RANK_TOLERANCE * across.max()
        reach = float(across[turned] @ most[turned])
        share = max(share, abs(float(normal @ np.asarray(stored))) / reach)
    return share


def reaction_wheels(
    axes: Any,
    inertia: Any,
    torque_limit: Any,
    speed_limit: Any = np.inf,
    efficiency: Any = 1.0,
    regeneration: Any = 0.0,
    *,
    notes: list[str] | None = None,
) -> ReactionWheels:
    """Return checked reaction wheels.

    Parameters
    ----------
    axes : (3, n) array_like
        Spin axes in body components, one column a wheel; scaled to unit length.
    inertia : float or (n,) array_like [kg m^2]
    torque_limit : float or (n,) array_like [N m]
    speed_limit : float or (n,) array_like [rad/s]
        ``inf``, the default, means no limit.
    efficiency : float
        Of the drives, greater than 0 and at most 1.
    regeneration : float
        Share of the braking power that the drives recover, from 0 to 1.
    notes : list of str, optional
        Receives a line for every axis whose length was not 1.

    Raises
    ------
    FieldError
        A `ValueError` that names the field, the value and what is allowed.
    """
    unit_axes = _unit_axes(axes, [] if notes is None else notes)
    count = unit_axes.shape[1]
    return ReactionWheels(
        axes=unit_axes,
        inertia=positive_per_item("inertia", inertia, count),
        torque_limit=positive_per_item("torque_limit", torque_limit, count),
        speed_limit=positive_per_item("speed_limit", speed_limit, count, infinite=True),
        efficiency=_share("efficiency", efficiency),
        regeneration=_share("regeneration", regeneration, zero=True),
    )


def _share(field: str, value: Any, *, zero: bool = False) -> Float64:
    share = finite_array(field, value)
    if share.ndim or not (0.0 < share <= 1.0 or (zero and share == 0.0)):
        least = "from 0" if zero else "greater than 0"
        raise FieldError(field, f"is {brief(value)}; give one number {least} and at most 1")
    return share


def _unit_axes(axes: Any, notes: list[str]) -> Float64:
    array = finite_array("axes", axes)
    if array.ndim != 2 or array.shape[0] != 3 or array.shape[1] == 0:
        raise FieldError(
            "axes",
            f"has shape {array.shape}, expected (3, n): three body components for each of n wheels",
        )
    lengths = np.linalg.norm(array, axis=0)
    for index, length in enumerate(lengths):
        if length < 1e-12:
            raise FieldError(
                "axes", f"wheel {index + 1} has the axis (0, 0, 0); give the direction of its spin"
            )
        if abs(length - 1.0) > _UNIT_TOLERANCE:
            notes.append(
                f"wheel axis {index + 1} was scaled to unit length; its length was {length:.6g}"
            )
    unit: Float64 = array / lengths[None, :]
    left, singular, _ = np.linalg.svd(unit)
    smallest = singular[2] if singular.size == 3 else 0.0
    if smallest < _RANK_TOLERANCE * singular[0]:
        blind = ", ".join(f"{component:.3g}" for component in left[:, 2] + 0.0)
        rank = int((singular >= _RANK_TOLERANCE * singular[0]).sum())
        raise FieldError(
            "axes",
            f"the {array.shape[1]} wheel axes span {rank} of the three directions: no wheel can "
            f"turn the body about ({blind}); add or tilt a wheel so that the axes span all three",
        )
    return unit
