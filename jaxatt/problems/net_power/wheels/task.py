"""A manoeuvre with wheels as a task of the solver: form, parameters, and what states mean."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.external import ExternalTorques
from jaxatt.problems.motor_torques import in_shares
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Satellite
from jaxatt.problems.net_power.sun_directions import Directions, best_directions
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.longer import at_nodes
from jaxatt.problems.net_power.wheels.parameters import Management, WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.sampling import environment, sun_along
from jaxatt.problems.wheel_speeds import speed_range
from jaxatt.runtime.arrays import Counts, Floats
from jaxatt.spacecraft import Spacecraft
from jaxatt.spacecraft.battery import Battery

SMOOTHING = 1e-8
"""alpha of (2.11) for the panels: rounds off the corner of a hundredth of a degree."""
EFFORT = 1e-4
"""Price of full torque on one wheel, as a share of the panels' best power."""
_ROUNDING = 3e-3
"""Dipole below which the magnitude in its price is rounded, as a share of the limit."""
_STILL = 1e-12


@dataclass(frozen=True, eq=False)
class WheelsTask:
    """A manoeuvre as the solver sees it.

    best : directions, in body axes, from which the sun is best.
    held : (M,), of how many of the manoeuvre's intervals each one of the programme is made; those
    of the programme that only fill up are not counted.
    """

    manoeuvre: Manoeuvre
    form: WheelsForm
    parameters: WheelsParameters
    best: Directions = field(repr=False)
    held: Counts = field(repr=False)


def rotation(q: Floats) -> Floats:
    """Rotation matrix R(q), from body to inertial axes."""
    w, v = q[0], q[1:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    matrix: Floats = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    return matrix


def wheels_task(
    manoeuvre: Manoeuvre,
    substeps: int | None = None,
    size: int | None = None,
    held: Counts | None = None,
    edges: float = 0.0,
) -> WheelsTask:
    """Make the task of a manoeuvre.

    substeps : in place of the manoeuvre's own.  size : intervals of the programme where they are to
    be more than the manoeuvre's; those without length fill up, so that manoeuvres of several
    lengths share a compiled search.  held : see `WheelsTask`; by default one each.
    edges : [rad], width of the shadow's edges; 0 is exact.
    Raises ValueError where the satellite lacks what the manoeuvre asks for.
    """
    satellite = manoeuvre.satellite
    craft = _checked(satellite)
    arms = _Arms.of(craft)
    q = np.asarray(manoeuvre.start.q_ib, float)
    q = q / np.linalg.norm(q)
    omega, spin = (
        np.asarray(v, float) for v in (manoeuvre.start.omega_ib, manoeuvre.start.omega_bw)
    )
    total = rotation(q) @ (arms.inertia @ omega + arms.axes @ (arms.wheel_inertia * spin))
    steps = substeps or manoeuvre.substeps or 1
    form = _form(manoeuvre, arms, float(np.linalg.norm(total)), steps)
    slowest, fastest, share = wheel_ranges(manoeuvre, spin)
    axial = arms.wheel_inertia * (spin + arms.axes.T @ omega)
    start = [q, arms.coordinates(axial, form)]
    power = _Power.of(satellite, craft, manoeuvre, arms, spin)
    if form.torqued:
        start.append(total / arms.scale)
    if form.charge:
        start.append(np.array([manoeuvre.charge / power.energy_scale]))
    held = np.ones(manoeuvre.intervals, int) if held is None else held
    size = max(size or 0, len(held))
    stages, last_sun, last_shone = _stages(manoeuvre, form, power.battery, size, held, edges)
    end = manoeuvre.end
    reference = q if end is None else np.asarray(end.q_ib, float)
    ending = np.zeros(form.stored)
    rows = np.zeros((0, form.stored))
    if end is not None and end.omega_bw is not None:
        wanted = arms.wheel_inertia * (
            np.asarray(end.omega_bw, float) + arms.axes.T @ np.asarray(end.omega_ib, float)
        )
        ending, rows = arms.coordinates(wanted, form), _end_rows(arms, form)
    leaves: dict[str, Any] = dict(
        start=np.concatenate(start),
        total=total,
        inertia=arms.inertia,
        without_spin=arms.without_spin,
        inverse=arms.inverse,
        to_rate=arms.scale * arms.inverse @ arms.axes if form.each else np.eye(3),
        to_stored=arms.to_stored(form),
        axes=arms.axes,
        wheel_inertia=arms.wheel_inertia,
        torque_limit=arms.torque_limit,
        motors=in_shares(craft.wheels),
        speed_lower=slowest,
        speed_upper=fastest,
        motor_limit=share,
        momentum_scale=np.asarray(arms.scale),
        energy_scale=np.asarray(power.energy_scale),
        power_scale=np.asarray(power.power_scale),
        taken=np.asarray(power.taken),
        returned=np.asarray(power.returned),
        effort=np.asarray(EFFORT * power.best),
        panels=craft.panels,
        smoothing=np.asarray(SMOOTHING),
        stages=stages,
        torques=satellite.torques if form.torqued else ExternalTorques(),
        management=_management(satellite, craft, arms) if form.torqued else None,
        dipole_limit=power.dipole_limit,
        dipole_price=power.dipole_price,
        dipole_loss=power.dipole_loss,
        rounding=np.asarray(_ROUNDING * power.dipole_limit.max()),
        reference=reference / np.linalg.norm(reference),
        reference_rate=np.zeros(3) if end is None else np.asarray(end.omega_ib, float),
        held=np.eye(3) if end is None else end.held,
        reference_stored=ending,
        end_rows=rows,
        spread=np.linalg.inv(arms.axes @ arms.axes.T),
        attitude_weight=np.asarray(float(manoeuvre.attitude_weight)),
        rate_weight=np.asarray(float(manoeuvre.rate_weight)),
        load=np.asarray(manoeuvre.load / float(power.battery.output_efficiency)),
        floor=np.asarray(manoeuvre.floor / power.energy_scale if form.charge else 0.0),
        last_shone=last_shone,
        last_sun=last_sun,
    )
    return WheelsTask(manoeuvre, form, WheelsParameters(**leaves), power.directions, held)


def _checked(satellite: Satellite) -> Spacecraft:
    craft = satellite.craft
    if craft.panels is None:
        raise ValueError("panels: the vehicle has none; give it solar panels")
    if craft.wheels.count == 0:
        raise ValueError("wheels: the vehicle has none; this manoeuvre needs at least three")
    if satellite.decided_dipole and craft.magnetorquers is None:
        raise ValueError("magnetorquers: the vehicle has none, so no dipole can be decided")
    return craft


@dataclass(frozen=True, eq=False)
class _Arms:
    """Inertias and mounting as plain arrays."""

    inertia: Floats
    without_spin: Floats
    inverse: Floats
    axes: Floats
    wheel_inertia: Floats
    torque_limit: Floats
    scale: float

    @classmethod
    def of(cls, craft: Spacecraft) -> _Arms:
        without = np.asarray(craft.inertia_without_spin, float)
        wheels = craft.wheels
        return cls(
            np.asarray(craft.inertia, float),
            without,
            np.linalg.inv(without),
            np.asarray(wheels.axes, float),
            np.asarray(wheels.inertia, float),
            np.asarray(wheels.torque_limit, float),
            float(np.trace(without) / 3.0),
        )

    @property
    def alike(self) -> bool:
        """Whether all wheels have the same inertia."""
        inertia = self.wheel_inertia
        return bool(np.ptp(inertia) <= 1e-12 * inertia.max())

    def coordinates(self, axial: Floats, form: WheelsForm) -> Floats:
        """Coordinates of the wheels' momentum, of axial momenta (n,) [N m s]."""
        if form.each:
            each: Floats = axial / self.scale
            return each
        summed: Floats = self.inverse @ self.axes @ axial
        return summed

    def to_stored(self, form: WheelsForm) -> Floats:
        """Derivative of the coordinates by the scaled torques, (k, n)."""
        limits = np.diag(self.torque_limit)
        return limits / self.scale if form.each else self.inverse @ self.axes @ limits


def _form(manoeuvre: Manoeuvre, arms: _Arms, total: float, substeps: int) -> WheelsForm:
    satellite, end = manoeuvre.satellite, manoeuvre.end
    torques = satellite.torques
    acting = satellite.gravity_gradient or any(
        part is not None
        for part in (
            torques.drag,
            torques.solar_pressure,
            torques.residual_dipole,
            torques.eddy_currents,
        )
    )
    managing = satellite.momentum is not None and not satellite.decided_dipole
    torqued = satellite.orbit is not None and (
        acting or managing or satellite.decided_dipole or bool(np.any(satellite.orbit.sine))
    )
    speeds = end is not None and end.omega_bw is not None and manoeuvre.terminal != "penalty"
    magnetorquers = "decided" if satellite.decided_dipole else "managing" if managing else "none"
    still = total <= _STILL * arms.scale
    wheels, limited = satellite.craft.wheels, manoeuvre.limits is not None
    speed_limited = limited and wheels.has_speed_limits
    motor_limited = limited and not wheels.motors.ideal
    rubbing = wheels.motors.rubbing
    watched = speed_limited or motor_limited or rubbing
    return WheelsForm(
        wheels=arms.axes.shape[1],
        momentum="carried" if torqued else "zero" if still else "constant",
        power=satellite.wheel_power,
        each=satellite.wheel_power == "wheels" or speeds or watched or not arms.alike,
        rubbing=rubbing,
        speed_limited=speed_limited,
        motor_limited=motor_limited,
        magnetorquers=magnetorquers if torqued else "none",
        end=_kind_of_end(manoeuvre),
        speeds=speeds,
        charge=math.isfinite(manoeuvre.floor),
        substeps=substeps,
    )


def wheel_ranges(manoeuvre: Manoeuvre, spin: Floats) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest speed of each wheel [rad/s], and the share of its motor's torque, (n,)."""
    limits = manoeuvre.limits
    if limits is None:
        endless = np.full(len(spin), np.inf)
        return -endless, endless, np.ones(len(spin))
    wheels = manoeuvre.satellite.craft.wheels
    return *speed_range(wheels, spin, limits.slower, limits.every_band), 1.0 - limits.weaker


def _kind_of_end(manoeuvre: Manoeuvre) -> str:
    if manoeuvre.end is None:
        return "free"
    points = manoeuvre.end.boresight is not None and manoeuvre.terminal == "reach"
    return "point" if points else manoeuvre.terminal


def _end_rows(arms: _Arms, form: WheelsForm) -> Floats:
    """Rows of the wheels' coordinates that can be asked for at the end.

    Without a dipole that is decided, the sum of the momenta follows from attitude and rate.
    """
    if form.magnetorquers == "decided":
        rows: Floats = np.eye(form.stored)
        return rows
    _, _, across = np.linalg.svd(arms.axes)
    rows = across[3:]
    return rows


@dataclass(frozen=True, eq=False)
class _Power:
    """What gains and costs energy."""

    battery: Battery
    directions: Directions
    best: float
    energy_scale: float
    power_scale: float
    taken: float
    returned: float
    dipole_limit: Floats
    dipole_price: Floats
    dipole_loss: Floats

    @classmethod
    def of(
        cls,
        satellite: Satellite,
        craft: Spacecraft,
        manoeuvre: Manoeuvre,
        arms: _Arms,
        spin: Floats,
    ) -> _Power:
        battery = craft.battery or Battery(np.inf, 0.0)
        kept, fed = float(battery.input_efficiency), 1.0 / float(battery.output_efficiency)
        assert craft.panels is not None
        directions = best_directions(craft.panels)
        best = float(satellite.light.irradiance) * directions.most * kept
        time = math.sqrt(arms.scale / arms.torque_limit.max())
        fast = arms.torque_limit.max() * time / arms.wheel_inertia.min() + np.abs(spin).max()
        braking = float(craft.wheels.braking_cost)
        driving = 1.0 / float(craft.wheels.efficiency)
        limit, price, loss = np.ones(3), np.zeros(3), np.zeros(3)
        if craft.magnetorquers is not None:
            limit = np.asarray(craft.magnetorquers.dipole_limit, float)
            loss = fed * np.asarray(craft.magnetorquers.loss_coefficient, float)
            if craft.magnetorquers.full_power is not None:
                price = fed * float(craft.magnetorquers.full_power) / (3.0 * limit)
        return cls(
            battery,
            directions,
            best,
            best * time,
            float(arms.torque_limit.max() * fast),
            fed * driving,
            fed * (driving if satellite.wheel_power == "body" else braking),
            limit,
            price,
            loss,
        )


def _management(satellite: Satellite, craft: Spacecraft, arms: _Arms) -> Management | None:
    if satellite.momentum is None or satellite.decided_dipole:
        return None
    limit: Any = np.full(3, np.inf)
    if craft.magnetorquers is not None:
        limit = np.asarray(craft.magnetorquers.dipole_limit, float)
    speed: Any = np.asarray(satellite.momentum.wheel_speed, float)
    law = MomentumDumping(float(satellite.momentum.gain), speed, printed=True)
    return Management(law, arms.axes @ (arms.wheel_inertia * speed), limit)


def _stages(
    manoeuvre: Manoeuvre,
    form: WheelsForm,
    battery: Battery,
    size: int,
    held: Counts,
    edges: float,
) -> tuple[WheelStage, Any, Any]:
    satellite, count = manoeuvre.satellite, len(held)
    direction, shone = sun_along(
        satellite.orbit,
        satellite.light,
        manoeuvre.start_time,
        manoeuvre.step,
        manoeuvre.intervals,
        edges,
    )
    nodes = np.concatenate([[0], np.cumsum(held)])
    direction, shone = direction[nodes], float(battery.input_efficiency) * at_nodes(shone, nodes)
    step = manoeuvre.step * held
    along = None
    if form.torqued and satellite.orbit is not None:
        within = (np.arange(form.substeps) + 0.5) / form.substeps
        middles = manoeuvre.start_time + manoeuvre.step * (
            nodes[:-1, None] + held[:, None] * within
        )
        along = environment(satellite.orbit, satellite.torques, satellite.gravity_gradient, middles)
    parts: tuple[Any, ...] = (step, step, direction[:-1], shone[:-1], along)
    stages = WheelStage(*parts)
    idle = jax.tree.map(lambda leaf: np.repeat(leaf[-1:], size - count, axis=0), stages)
    nothing: Any = np.zeros(size - count)
    idle = idle._replace(step=nothing, shone=nothing)
    filled = jax.tree.map(lambda a, b: np.concatenate([a, b]), stages, idle)
    return filled, direction[-1], shone[-1]
