"""Parameters of a manoeuvre with wheels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
from jax import Array

from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.spacecraft.panels import SolarPanels
from jaxatt.spacecraft.wheel_motor import WheelMotors


class WheelStage(NamedTuple):
    """What changes from interval to interval.

    step : () [s], length of the interval; 0 in those that only fill up.
    paid : () [s], the same for what controls cost, which keeps those of the others determined.
    sun : (3,), unit vector in inertial axes at the node where the interval begins.
    shone : () [J/m^2], what falls on a square metre that faces the sun, integrated over the hat
        function of that node; battery's input efficiency included.
    along : environment in the middle of every substep, leading axis substeps; None where nothing
        asks for it.
    """

    step: Array
    paid: Array
    sun: Array
    shone: Array
    along: Along | None


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Management:
    """Law of the magnetorquers that manage the wheels' momentum.

    law : of the dipole.  kept : (3,) [N m s], momentum A Jw omega_bw to keep.
    dipole_limit : (3,) [A m^2].
    """

    law: MomentumDumping
    kept: Array
    dipole_limit: Array


OF_MANOEUVRE = frozenset(
    {
        "start",
        "total",
        "power_scale",
        "stages",
        "reference",
        "reference_rate",
        "reference_stored",
        "speed_lower",
        "speed_upper",
        "motor_limit",
        "load",
        "last_shone",
        "last_sun",
    }
)
"""Parameters that belong to a manoeuvre; the others belong to the satellite or to what is asked."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class WheelsParameters:
    """Parameters of a manoeuvre with wheels; every leaf may be batched, swept or differentiated.

    A state holds q_ib (4); the wheels' axial momenta relative to inertial, their sum in body axes
    as the rate J_s^-1 A s (3) that they take from the body, or each, s / momentum_scale (n)
    [rad/s]; where it is carried the total momentum in inertial axes over `momentum_scale` (3)
    [rad/s]; and where it is carried the charge over `energy_scale`.

    start : (s,).  total : (3,) [N m s], momentum in inertial axes; not read where it is carried.
    inertia : (3, 3) [kg m^2], wheels included.  without_spin : J_s.  inverse : of J_s.
    to_rate : (3, k), rate that the body loses to a unit of the wheels' coordinates.
    to_stored : (k, n) [1/s], derivative of these by the scaled torques.
    axes : (3, n).  wheel_inertia : (n,).  torque_limit : (n,) [N m], of a unit of a control.
    motors : of the wheels, friction in shares of the torque limits.
    speed_lower, speed_upper : (n,) [rad/s], range of every wheel.  motor_limit : (n,), share of the
        motors' torque that may be used.
    momentum_scale : () [kg m^2].  energy_scale : () [J].  power_scale : () [W].
    taken, returned : () of the wheels' power: what it costs per watt where it is positive, and
        where it is negative.
    effort : () [W], small price of squared scaled torques, which decides what is otherwise open.
    panels : of the vehicle.  smoothing : () alpha of (2.11).
    stages : leading axis N.
    torques : external.  management : law of the magnetorquers.
    dipole_limit : (3,) [A m^2].  dipole_price : (3,) [W/(A m^2)] of magnitudes, dipole_loss : (3,)
        [W/(A m^2)^2] of squares, and rounding : () [A m^2] of the magnitudes.
    reference, reference_rate : (4,), (3,) [rad/s] to end in; the quaternion's sign picks the way.
    held : (3, 3) or (2, 3), body axes about which the attitude at the end is held.
    reference_stored : (k,), coordinates of the wheels at the end; end_rows : (r, k), what of them
        is asked for.
    spread : (3, 3), inverse of A A'.
    attitude_weight, rate_weight : () [J], [J s^2] of (3.5).
    load : () [W].  floor : () charge over `energy_scale`.
    last_shone : () [J/m^2] and last_sun : (3,), of the last node.
    """

    start: Array
    total: Array
    inertia: Array
    without_spin: Array
    inverse: Array
    to_rate: Array
    to_stored: Array
    axes: Array
    wheel_inertia: Array
    torque_limit: Array
    motors: WheelMotors
    speed_lower: Array
    speed_upper: Array
    motor_limit: Array
    momentum_scale: Array
    energy_scale: Array
    power_scale: Array
    taken: Array
    returned: Array
    effort: Array
    panels: SolarPanels
    smoothing: Array
    stages: WheelStage
    torques: ExternalTorques
    management: Management | None
    dipole_limit: Array
    dipole_price: Array
    dipole_loss: Array
    rounding: Array
    reference: Array
    reference_rate: Array
    held: Array
    reference_stored: Array
    end_rows: Array
    spread: Array
    attitude_weight: Array
    rate_weight: Array
    load: Array
    floor: Array
    last_shone: Array
    last_sun: Array
