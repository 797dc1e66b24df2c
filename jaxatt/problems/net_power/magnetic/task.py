"""Task of a manoeuvre by magnetorquers alone: what the solver works with, and its cost."""

from __future__ import annotations

import math
from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from jaxatt.environment.epoch import SECONDS_PER_DAY
from jaxatt.environment.in_time import in_time
from jaxatt.environment.light import sunlight
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.magnetic.manoeuvre import FreeManoeuvre
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.orbit_frame import inertial_pose, rotated_back
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.net_power.sun_attitude import sun_attitude
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import collecting_area

SUBSTEPS = 4
"""Runge-Kutta steps an interval where nobody says how many."""
_TYPICAL_FIELD = 3e-5
"""[T] In low orbits; it only sets a unit of time."""
_USUAL_POWER = 16.0
"""[W] Of the panels of a CubeSat; costs count in what other panels give more or less."""
_WIDTH = 0.02
"""[rad] In which the light changes at an edge of the shadow, for the first passes."""
_SMOOTHING = 1e-7
"""alpha of the smooth maximum (2.11), table 6.2 of Kristiansen (2023)."""


class MagneticTask:
    """Manoeuvre in free time as arguments of its programme.

    Raises `ValueError` where the satellite lacks something, or has what is not supported.
    """

    def __init__(self, manoeuvre: FreeManoeuvre):
        _check(manoeuvre)
        self.manoeuvre = manoeuvre
        self.craft = manoeuvre.satellite.craft
        self.unit = self._unit()
        self.parameters = self._parameters()

    def form(self, exact: bool, substeps: int | None = None) -> MagneticForm:
        """Static choices of a solve; one that is not exact takes half as many steps an interval."""
        m = self.manoeuvre
        steps = m.substeps or SUBSTEPS
        return MagneticForm(
            mean_power=m.cost == "mean-power",
            reach=m.terminal == "reach",
            orbit_frame=m.frame == "orbit",
            gravity_gradient=m.satellite.gravity_gradient,
            exact=exact,
            substeps=substeps or (steps if exact else max(1, steps // 2)),
        )

    @property
    def dipole_limit(self) -> Floats:
        """Largest dipoles (3,) [A m^2]."""
        assert self.craft.magnetorquers is not None
        return np.asarray(self.craft.magnetorquers.dipole_limit, float)

    def target_at(self, final_time: float) -> Pose:
        """Pose in inertial axes to end in at a final time [s]."""
        m = self.manoeuvre
        wanted = InitialState(m.target.q_ob, m.target.omega_ob, np.zeros(0))
        return inertial_pose(wanted, m.frame, m.satellite.orbit, m.start_time + final_time)

    def sun_attitudes(self, near: Floats, time: float) -> Floats:
        """Attitudes q_ib (S, 4) of the most power, each near another (S, 4), at a time [s]."""
        assert self.craft.panels is not None
        irradiance = float(self.manoeuvre.satellite.light.irradiance)
        return sun_attitude(self.craft.panels, irradiance, self.sun_at(time), near)

    def sun_at(self, time: float) -> Floats:
        """Direction (3,) of the sun in inertial axes at a time [s] after the start."""
        m = self.manoeuvre
        assert m.satellite.orbit is not None
        days = m.satellite.orbit.days + (m.start_time + time) / SECONDS_PER_DAY
        direction, _ = sunlight(m.satellite.light, jnp.zeros(3), days)
        return np.asarray(direction)

    def sharper(self, width: float) -> MagneticParameters:
        """Parameters with an edge of the shadow of another width [rad]."""
        return replace(self.parameters, shadow_width=jnp.asarray(width))

    def _unit(self) -> float:
        inertia = float(np.max(np.diag(np.asarray(self.craft.inertia))))
        return math.sqrt(inertia / (float(self.dipole_limit.max()) * _TYPICAL_FIELD))

    def _parameters(self) -> MagneticParameters:
        m, craft, satellite = self.manoeuvre, self.craft, self.manoeuvre.satellite
        assert satellite.orbit is not None and craft.magnetorquers is not None
        assert craft.panels is not None
        light, torques = satellite.light, satellite.torques
        battery = craft.battery
        stored = 1.0 if battery is None else float(battery.input_efficiency)
        given = 1.0 if battery is None else float(battery.output_efficiency)
        limit = self.dipole_limit
        residual = torques.residual_dipole
        n = m.intervals
        start = np.concatenate([_unit_quaternion(m.start.q_ib), self.unit * m.start.omega_ib])
        energy = m.cost == "energy"
        best = self.sun_attitudes(start[None, :4], 0.0)[0]
        seen = rotated_back(best, self.sun_at(0.0))
        area = float(collecting_area(craft.panels, jnp.asarray(seen)))
        # The nearest power of two rounds nothing.
        power = math.ldexp(1.0, round(math.log2(stored * light.irradiance * area / _USUAL_POWER)))
        return MagneticParameters(
            environment=in_time(satellite.orbit, light, m.start_time, m.start_time + m.longest),
            shadow=light.shadow,
            panels=craft.panels,
            irradiance=jnp.asarray(stored * light.irradiance),
            best_area=jnp.asarray(area),
            load=jnp.asarray(m.load / given),
            inertia=jnp.asarray(craft.inertia),
            inverse=jnp.asarray(np.linalg.inv(np.asarray(craft.inertia))),
            residual=jnp.zeros(3) if residual is None else jnp.asarray(residual.dipole),
            other=replace(torques, residual_dipole=None),
            unit=jnp.asarray(self.unit),
            dipole_unit=jnp.asarray(limit),
            dipole_power=jnp.asarray(craft.magnetorquers.loss_coefficient * limit**2 / given),
            start=jnp.asarray(start),
            begin=jnp.asarray(m.start_time),
            final_time=jnp.asarray(m.shortest),
            time=jnp.arange(n) / n,
            share=jnp.full(n, 1.0 / n),
            reference=jnp.asarray(_unit_quaternion(m.target.q_ob)),
            reference_rate=jnp.asarray(m.target.omega_ob),
            attitude_weight=jnp.asarray(m.attitude_weight),
            rate_weight=jnp.asarray(m.rate_weight),
            time_weight=jnp.asarray(m.time_weight),
            scale=jnp.asarray((1.0 / (10.0 * self.unit) if energy else 1.0) / power),
            panel_smoothing=jnp.asarray(_SMOOTHING),
            shadow_width=jnp.asarray(_WIDTH),
            shortest=jnp.asarray(m.shortest),
            longest=jnp.asarray(m.longest),
        )


def _unit_quaternion(q: Floats) -> Floats:
    q = np.asarray(q, float)
    unit: Floats = q / np.linalg.norm(q)
    return unit


def _check(m: FreeManoeuvre) -> None:
    """Refuse what the programme does not support."""
    satellite, craft = m.satellite, m.satellite.craft
    if craft.wheels.count:
        raise ValueError("vehicle: has wheels; free time is for magnetorquers alone")
    if craft.magnetorquers is None:
        raise ValueError("vehicle: has no magnetorquers; add [vehicle.magnetorquers]")
    if craft.magnetorquers.full_power is not None:
        raise ValueError(
            "vehicle.magnetorquers.full_power_W: in free time the power must be that of the coils' "
            "resistance; give turns, coil_area_m2 and resistance_ohm"
        )
    if craft.panels is None:
        raise ValueError("vehicle: has no panels; add [vehicle.panels]")
    if satellite.orbit is None or satellite.orbit.field is None:
        raise ValueError("orbit: magnetorquers need one, with an epoch for the magnetic field")
    if satellite.torques.drag is not None:
        raise ValueError("disturbances: drag is not supported in free time; leave it out")
    if not 0.0 < m.shortest < m.longest:
        raise ValueError(
            f"shortest_s, longest_s: {m.shortest:g} and {m.longest:g}; both must be greater than "
            "0, and the second greater than the first"
        )
