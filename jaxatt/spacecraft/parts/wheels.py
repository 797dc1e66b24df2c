"""A set of reaction wheels in any mounting that spans three directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, Float64, brief, finite_array, positive_per_item
from jaxatt.spacecraft.parts.array import Array
from jaxatt.spacecraft.parts.speed_bands import NO_BANDS, SpeedBands, speed_bands
from jaxatt.spacecraft.parts.wheel_motor import WheelMotors, wheel_motors
from jaxatt.spacecraft.wheel_envelope import envelope_share, spanned_directions

# Rounded axes such as 0.57735 are meant as unit vectors: only a larger deviation earns a note.
_UNIT_TOLERANCE = 1e-5
_NO_MOTORS = wheel_motors(0)


@dataclass(frozen=True, eq=False)
class ReactionWheels:
    """Reaction wheels that work; build them with `reaction_wheels`, which checks the numbers.

    Names are for reports on the host only: transformations drop them, so that none recompiles.

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
    avoid : SpeedBands
        Speeds at which the wheels must not run.
    motors : WheelMotors
        Their friction, and how their torque falls with speed.
    mounted : tuple of str
        Names of all wheels that are mounted; empty for "wheel 1", "wheel 2" and so on.
    failed : tuple of str
        Those of them that do not work: their columns are left out of every array above.
    """

    axes: Array
    inertia: Array
    torque_limit: Array
    speed_limit: Array
    efficiency: Array | float = 1.0
    regeneration: Array | float = 0.0
    avoid: SpeedBands = NO_BANDS
    motors: WheelMotors = _NO_MOTORS
    mounted: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """Number of wheels that work."""
        return int(self.axes.shape[-1])

    @property
    def has_speed_limits(self) -> bool:
        """Whether there are speeds that a wheel must never have, or must leave soon."""
        return self.avoid.count > 0 or bool(np.isfinite(np.asarray(self.speed_limit)).any())

    @property
    def mounted_names(self) -> tuple[str, ...]:
        """Names of all wheels, failed ones among them."""
        return self.mounted or tuple(f"wheel {place + 1}" for place in range(self.count))

    @property
    def working(self) -> tuple[int, ...]:
        """Places of the wheels that work among all that are mounted, counted from 0."""
        names = enumerate(self.mounted_names)
        return tuple(place for place, name in names if name not in self.failed)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the wheels that work, in the order of all arrays."""
        return tuple(self.mounted_names[place] for place in self.working)

    @property
    def allocation(self) -> Array:
        """Moore-Penrose inverse from body to wheel torque, (n, 3); Schaanning (2021), eq. 2.42.

        The mounting has full row rank, so the pseudo-inverse is ``A' (A A')^-1``: smooth in the
        axes, where one by singular values has no derivative for equal singular values.
        """
        # Plain numbers stay on the host, where nothing has to be compiled.
        axes: Any = self.axes
        library = axes.__array_namespace__()
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
        Greater than 1 where no speeds within the limits hold it.
    """
    most = np.asarray(wheels.inertia) * np.asarray(wheels.speed_limit)
    return envelope_share(np.asarray(wheels.axes), most, np.asarray(stored))


def reaction_wheels(
    axes: Any,
    inertia: Any,
    torque_limit: Any,
    speed_limit: Any = np.inf,
    efficiency: Any = 1.0,
    regeneration: Any = 0.0,
    *,
    avoid: Sequence[tuple[Any, Any, Any]] = (),
    motors: Mapping[str, Any] | None = None,
    names: Sequence[str] = (),
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
    avoid : sequence of (slowest, fastest, longest stay)
        As in `speed_bands`.
    motors : dict, optional
        Arguments of `wheel_motors`.
    names : sequence of str
        One for each wheel; "wheel 1", "wheel 2" and so on by default.
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
        avoid=speed_bands(avoid, count),
        motors=wheel_motors(count, **(motors or {})),
        mounted=_names(names, count),
    )


def _names(names: Sequence[str], count: int) -> tuple[str, ...]:
    if not names:
        return ()
    if len(names) != count:
        raise FieldError("names", f"has {len(names)} names; give one for each of {count} wheels")
    if len(set(names)) < count or not all(name.strip() for name in names):
        raise FieldError("names", "are not told apart; give every wheel a name of its own")
    return tuple(names)


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
    spanned, blind = spanned_directions(unit)
    if spanned < 3:
        raise FieldError(
            "axes",
            f"the {array.shape[1]} wheel axes span {spanned} of the three directions: no wheel can "
            f"turn the body about ({blind}); add or tilt a wheel so that the axes span all three",
        )
    return unit
