"""Read the tables of a flight's file, one function each."""

from __future__ import annotations

import math
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment import epoch
from jaxatt.environment.aerodynamic_drag import Drag
from jaxatt.environment.eddy_currents import EddyCurrents
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.environment.solar_radiation_pressure import SolarPressure
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.reading.aims import read_followed, read_state
from jaxatt.problems.reading.attitude_files import read_path, refuse_beside_file
from jaxatt.problems.reading.attitudes import attitude_given
from jaxatt.problems.reading.dates import read_epoch
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.attitude import POSE_KEYS
from jaxatt.problems.reading.wheel_speeds import read_wheel_speeds
from jaxatt.problems.scenario import Orbit
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.flight_model import Asked, Surroundings, Timing
from jaxatt.scenarios.flight_schema import DRAG_KEYS, FLIGHT_TABLES, MOST_STEPS, SOLAR_KEYS
from jaxatt.simulation.campaign import Spread
from jaxatt.spacecraft import Spacecraft

_WHOLE = 1e-6


def read_environment(data: Any, origin: str, orbit: Orbit | None) -> Surroundings:
    """Read which torques act; all but the sine need an orbit, the magnetic ones an epoch too."""
    table = Table(data, origin, "[environment]", FLIGHT_TABLES["environment"])
    if orbit is None:
        for key in table.data:
            if not key.startswith("sinusoidal"):
                table.fail(key, "needs an orbit", "add [orbit], or drop it")
    drag = solar = None
    if "drag" in table:
        inner = Table(table.data["drag"], origin, "[environment.drag]", DRAG_KEYS)
        drag = Drag(
            inner.number("density_kg_m3"),
            inner.number("area_m2"),
            inner.number("coefficient"),
            jnp.asarray(inner.vector("lever_m")),
            epoch.EARTH_RATE if inner.flag("corotating") else 0.0,
        )
    if "solar_pressure" in table:
        inner = Table(
            table.data["solar_pressure"], origin, "[environment.solar_pressure]", SOLAR_KEYS
        )
        solar = SolarPressure(
            inner.number("irradiance_W_m2"),
            inner.number("area_m2"),
            inner.number("reflectance"),
            jnp.asarray(inner.vector("lever_m")),
            inner.number("light_speed_m_s"),
        )
    dipole = eddy = None
    if "residual_dipole_Am2" in table:
        dipole = ResidualDipole(jnp.asarray(table.vector("residual_dipole_Am2")))
    if "eddy_coefficient" in table:
        eddy = EddyCurrents(table.number("eddy_coefficient"))
    sun = None
    if "sun_direction" in table:
        sun = table.vector("sun_direction")
        if not np.linalg.norm(sun) > 1e-12:
            table.fail("sun_direction", "is no direction", "give the direction to the sun")
        sun = sun / np.linalg.norm(sun)
    return Surroundings(
        orbit,
        read_epoch(table) if orbit is None else orbit.days,
        table.flag("gravity_gradient"),
        table.number("sinusoidal_torque_Nm"),
        table.number("sinusoidal_frequency_rad_s"),
        sun,
        ExternalTorques(drag, solar, dipole, eddy),
    )


def read_reference(
    data: Any,
    origin: str,
    initial: InitialState,
    notes: list[str],
    sky: Sky,
    timing: Timing,
) -> Asked:
    """Read the reference that the laws follow.

    sky : what its attitude may be told by.  timing : of the flight.
    """
    table = Table(data, origin, "[reference]", FLIGHT_TABLES["reference"])
    manoeuvre = table.text("manoeuvre", " ").strip()
    given = attitude_given(table)
    if manoeuvre and (given or "rate_rad_s" in table or "rate" in table):
        table.fail("manoeuvre", "given beside an attitude or rate", "keep one of them")
    since = table.number("from_s")
    path = None
    if "aem_file" in table:
        refuse_beside_file(table, (*POSE_KEYS, "rate_rad_s", "rate", "attitude_held", "manoeuvre"))
        last = timing.duration
        path = read_path(table, sky.folder, sky.days, min(since, last), last)
    elif "at" in table:
        table.fail("at", "given without aem_file", "name the file, or drop it")
    attitude, rate = initial.q_ob, table.vector("rate_rad_s")
    if given:
        path = read_followed(table, notes, sky, _instants(table, since, timing))
        if path is None:
            attitude, rate = read_state(table, notes, sky, since)
    elif "rate" in table:
        table.fail("rate", "given without an attitude", "add align with constrain, or attitude_deg")
    return Asked(
        attitude,
        rate,
        since,
        table.flag("attitude_held"),
        manoeuvre,
        path,
    )


def _instants(table: Table, since: float, timing: Timing) -> Floats:
    """Sampling instants (n,) [s] from one time on; the last two at least."""
    times = np.asarray(timing.sampling * np.arange(timing.samples + 1), np.float64)
    found = times[times >= since - 1e-9]
    if len(found) < 2 and "rate" in table:
        table.fail(
            "from_s",
            f"leaves nothing of a flight of {timing.duration:g} s",
            "give a time before its end",
        )
    return found if len(found) > 1 else times[-2:]


def read_timing(data: Any, origin: str) -> Timing:
    """Read duration, sampling period and step, each a whole multiple of the next."""
    table = Table(data, origin, "[simulation]", FLIGHT_TABLES["simulation"])
    table.choice("hold")
    duration = table.number("duration_s")
    sampling = table.number("sampling_s")
    step = table.number("step_s", sampling)
    records = table.integer("records")
    if duration / step > MOST_STEPS:
        table.fail(
            "step_s" if "step_s" in table else "sampling_s",
            f"the flight takes {duration / step:.3g} steps, more than {MOST_STEPS:g}",
            "give a longer step, or a shorter duration_s",
        )
    for key, whole, part, of in (
        ("sampling_s", sampling, step, "step_s"),
        ("duration_s", duration, sampling, "sampling_s"),
    ):
        count = whole / part
        if count < 1.0 - _WHOLE or abs(count - round(count)) > _WHOLE * count:
            below = part * max(1, math.floor(count))
            table.fail(
                key,
                f"is no multiple of {of} = {part:g}",
                f"give {below:g} or {below + part:g}, or change {of}",
            )
    samples = round(duration / sampling)
    fitting = max(n for n in range(1, min(records, samples) + 1) if samples % n == 0)
    tumbling = table.number("tumbling_rad_s")
    return Timing(duration, sampling, step, fitting, tumbling)


def read_settling(data: Any, origin: str, since: float) -> tuple[str, float, float]:
    """Read the watched signal, the width of its band, and the instant from which it counts."""
    table = Table(data, origin, "[settling]", FLIGHT_TABLES["settling"])
    signal = table.choice("signal")
    wrong, right = (
        ("band_rad_s", "band_deg") if signal == "attitude" else ("band_deg", "band_rad_s")
    )
    if wrong in table:
        table.fail(wrong, f"given for signal = {signal}", f"give {right}")
    if signal == "attitude":
        width = math.radians(table.number("band_deg"))
    else:
        width = table.number("band_rad_s")
    return signal, width, table.number("since_s", since)


def read_noise(data: Any, origin: str) -> tuple[float, float]:
    """Read the standard deviations of measured rate and wheel speed [rad/s]."""
    table = Table(data, origin, "[noise]", FLIGHT_TABLES["noise"])
    return (
        table.number("rate_rad_s"),
        table.number("wheel_speed_rad_s"),
    )


def read_dumping(
    data: Any, origin: str, vehicle: Spacecraft, around: Surroundings
) -> MomentumDumping:
    """Read the unloading law; it needs magnetorquers, an orbit and an epoch."""
    table = Table(data, origin, "[dumping]", FLIGHT_TABLES["dumping"])
    if vehicle.magnetorquers is None:
        table.fail(
            "gain_1_s",
            f"momentum dumping needs magnetorquers, which the vehicle {vehicle.name} lacks",
            "add [vehicle.magnetorquers] with dipole_limit_Am2, or drop [dumping]",
        )
    if around.orbit is None or around.days is None:
        table.fail(
            "gain_1_s",
            "momentum dumping needs the Earth's magnetic field",
            "add [orbit] and an epoch under [environment], or drop [dumping]",
        )
    return MomentumDumping(
        table.number("gain_1_s"),
        jnp.asarray(read_wheel_speeds(table, vehicle.wheels)),
        table.choice("form") == "printed",
    )


def read_campaign(data: Any, origin: str) -> tuple[Spread, int, int]:
    """Read the spread, the number of runs and the seed."""
    table = Table(data, origin, "[campaign]", FLIGHT_TABLES["campaign"])
    spread = Spread(
        math.radians(table.number("attitude_deg")),
        table.number("rate_rad_s"),
        table.number("inertia_percent") / 100.0,
        math.radians(table.number("misalignment_deg")),
        table.number("gain_percent") / 100.0,
    )
    return (
        spread,
        table.integer("runs"),
        table.integer("seed"),
    )
