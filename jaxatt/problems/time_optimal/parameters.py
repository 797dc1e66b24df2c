"""Parameters of a reorientation in free time."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.problems.pointing.cones import PointingLimits
from jaxatt.simulation.free_body import FreeBody
from jaxatt.spacecraft.wheel_motor import WheelMotors


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ReorientationParameters:
    """Parameters of a reorientation; every leaf may be batched, swept or differentiated.

    Inertias, and with them torques and momenta, are counted in a unit of about the vehicle's own
    inertia, `ReorientationTask.unit` [kg m^2], but `scale` is in N m.

    body : inertias.
    start : (s,), attitude, rate and, where it is carried, momentum at the first node.
    step : () [s], mean interval that a start begins with.
    share : (N,), lengths of the intervals in units of the mean one.
    reference : (4,) or (3,), target attitude; its sign or set selects the way round.
    reference_rate : (3,) [rad/s].
    held : (3, 3) or (2, 3), body axes about which the target's attitude is held.
    to_body, to_external : (3, b) [1/s^2], torque on the wheels and of the thrusters in body axes,
        of a unit of each scaled control.
    lower, upper : (b,), limits of the scaled controls.  scale : (b,) [N m].
    effort_weight : () [1/(N m)^2], rho.
    shortest, longest : () [s], limits of the final time; 0 and inf where there are none.
    limits : cones and rate limits.  directions : (m, 3), of the cones, in inertial axes.
    wheel_speed : (n,) [rad/s] at the first node; wheel_axes : (3, n); wheel_inertia : (n,);
    to_wheels : (n, b) and wheel_limit : (n,) [1/s^2]; speed_lower, speed_upper : (n,) [rad/s].
    null_momenta : (n - 3, n), of the wheels, which cancel in the body; wheel_bias : (n,) [rad/s],
        speeds at the end in that space, where they are asked for.
    motors : friction in units of the torque limits, and the fall of the torque; motor_limit : (n,),
        share of that limit that the programme allows.
    """

    body: FreeBody
    start: Array
    step: Array
    share: Array
    reference: Array
    reference_rate: Array
    held: Array
    to_body: Array
    to_external: Array
    lower: Array
    upper: Array
    scale: Array
    effort_weight: Array
    shortest: Array
    longest: Array
    limits: PointingLimits
    directions: Array
    wheel_speed: Array
    wheel_axes: Array
    wheel_inertia: Array
    to_wheels: Array
    speed_lower: Array
    speed_upper: Array
    null_momenta: Array
    wheel_bias: Array
    wheel_limit: Array
    motors: WheelMotors
    motor_limit: Array
