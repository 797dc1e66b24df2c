"""Parameters of a manoeuvre by magnetorquers alone in free time."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.in_time import EnvironmentInTime
from jaxatt.spacecraft.panels import SolarPanels


@dataclass(frozen=True)
class MagneticForm:
    """Static choices, which are compiled in.

    mean_power : whether the cost is the mean power, eq. (6.2a), or the energy.
    reach : whether the end is a constraint, or a cost as in eq. (6.6).
    orbit_frame : whether the target is given in the orbit frame, or else in the inertial one.
    gravity_gradient : whether it acts.
    exact : whether second derivatives are exact, or those of the cost alone, which are positive.
    substeps : Runge-Kutta steps an interval.
    """

    mean_power: bool
    reach: bool
    orbit_frame: bool
    gravity_gradient: bool
    exact: bool
    substeps: int


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class MagneticParameters:
    """Parameters; every leaf may be batched, swept or differentiated.

    environment : as a function of time.  shadow : of the Earth, or None.
    panels, irradiance : () [W/m^2], what reaches the battery.  best_area : () [m^2], the panels'
    largest.  load : () [W], of the other subsystems.
    inertia, inverse : (3, 3) [kg m^2] and its inverse.
    residual : (3,) [A m^2], dipole of the body.  other : external torques without it.
    unit : () [s], of time in the programme, with which rates and dipoles are of order one.
    dipole_unit : (3,) [A m^2], the largest dipoles, and dipole_power : (3,) [W], what they draw.
    start : (7,), q_ib and omega_ib [rad per unit of time].
    begin : () [s], time of the start since the epoch.
    final_time : () [s], with which a start begins.
    time, share : (N,), beginnings and lengths of the intervals in units of the final time.
    reference : (4,), attitude to end with; of its two signs the one that a start turns towards.
    reference_rate : (3,) [rad/s], rate to end with.
    attitude_weight, rate_weight : k1 and k2 of eq. (6.6), times 1 and s^2 in units of the cost.
    time_weight : k3, in units of the cost a second.
    scale : (), of the cost in the programme.
    panel_smoothing : alpha of eq. (2.11).  shadow_width : () [rad], greater than 0, of the edges
    of the shadow, as in `gradual_share`.
    shortest, longest : () [s], limits of the final time.
    """

    environment: EnvironmentInTime
    shadow: Shadow | None
    panels: SolarPanels
    irradiance: Array | float
    best_area: Array | float
    load: Array | float
    inertia: Array
    inverse: Array
    residual: Array
    other: ExternalTorques
    unit: Array | float
    dipole_unit: Array
    dipole_power: Array
    start: Array
    begin: Array | float
    final_time: Array | float
    time: Array
    share: Array
    reference: Array
    reference_rate: Array
    attitude_weight: Array | float
    rate_weight: Array | float
    time_weight: Array | float
    scale: Array | float
    panel_smoothing: Array | float
    shadow_width: Array | float
    shortest: Array | float
    longest: Array | float

    @property
    def others_act(self) -> bool:
        """Whether any of the other torques but the gravity gradient acts."""
        return self.other.eddy_currents is not None or self.other.solar_pressure is not None
