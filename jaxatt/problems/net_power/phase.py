"""Record of a manoeuvre that was flown, with its energies and how every start ended."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.environment import frames
from jaxatt.environment.eclipse_times import Eclipse, eclipses
from jaxatt.optimize.status import Status
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.motor_torques import motor_torque
from jaxatt.problems.net_power.broken_margins import broken_margins
from jaxatt.problems.net_power.flight import (
    PoweredFlight,
    fly_with_twice_the_steps,
    steps_for,
)
from jaxatt.problems.net_power.found import Flown
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Motion, Satellite
from jaxatt.problems.net_power.record import Energy, NetPower
from jaxatt.problems.wheel_speeds import band_records
from jaxatt.records.phase import Phase
from jaxatt.records.starts import StartsRecord
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight_error import FlightError, between
from jaxatt.spacecraft import Spacecraft

_ACTIVE, _FULL = 1e-3, 0.999
"""Share of its limit above which a control makes an interval count as active."""


def energy_of_flight(
    manoeuvre: Manoeuvre, flight: PoweredFlight, row: int, baseline: PoweredFlight | None
) -> Energy:
    """Energies of one of some flights.  baseline : flight of the PD law; None without."""
    account, battery = flight.energy, manoeuvre.satellite.craft.battery
    stored = battery is not None and np.isfinite(account.capacity)
    return Energy(
        solar=float(account.solar_J[row]),
        actuation=float(account.wheels_J[row] + account.magnetorquers_J[row]),
        loads=float(account.loads_J[row]),
        baseline=None if baseline is None else float(baseline.energy.net_J[0]),
        final_charge=float(account.charge[row, -1]) if stored else None,
        least_charge=float(account.least_charge[row]) if stored else None,
    )


def series_of(manoeuvre: Manoeuvre, flight: PoweredFlight, row: int) -> dict[str, Floats]:
    """Series of one of some flights at its nodes, and the torques held over its intervals."""
    satellite, load = manoeuvre.satellite, manoeuvre.load
    craft, count = satellite.craft, manoeuvre.intervals
    output = 1.0 if craft.battery is None else float(craft.battery.output_efficiency)
    step = float(flight.step[row])
    q, omega = flight.q_ib[row], flight.omega_ib[row]
    q_ob, omega_ob = _relative(satellite, manoeuvre.start_time + step * np.arange(count + 1), q)
    actuation = flight.wheel_power[row] + flight.magnetorquer_power[row]
    found = {
        "q_ob": q_ob,
        "omega_ob": omega - omega_ob,
        "q_ib": q,
        "omega_ib": omega,
        "omega_bw": flight.omega_bw[row],
        "light": flight.light[row],
        "solar_power": flight.solar_power[row],
        "actuation_power": actuation,
        "net_power": flight.solar_power[row] - actuation - load / output,
        "net_energy": np.concatenate([[0.0], np.cumsum(flight.energy.net[row])]),
    }
    if craft.battery is not None and np.isfinite(flight.energy.capacity):
        found["charge"] = flight.energy.charge[row]
    if craft.magnetorquers is not None:
        found["dipole"] = flight.dipole[row]
    if craft.wheels.count:
        torque = flight.wheel_torque[row]
        if not craft.wheels.motors.ideal:
            found["torque_motors"] = motor_torque(craft.wheels, torque, flight.omega_bw[row])
        found |= {"torque_wheels": torque, "torque_body": torque @ np.asarray(craft.wheels.axes).T}
    return found


def _relative(satellite: Satellite, times: Any, q_ib: Floats) -> tuple[Floats, Floats]:
    """Attitude q_ob (M, 4), and the orbit frame's rate (M, 3) [rad/s] in body axes."""
    around = satellite.orbit
    if around is None:
        return q_ib, np.zeros((len(q_ib), 3))
    here = around.motion.at(jnp.asarray(times))
    q_io = frames.quaternion_io(here.position, here.velocity)
    q_ob = quaternion.multiply(quaternion.conjugate(q_io), jnp.asarray(q_ib))
    rate = quaternion.rotate_inverse(q_ob, frames.omega_io(*here))
    return np.asarray(q_ob), np.asarray(rate)


def baseline_series(
    manoeuvre: Manoeuvre, baseline: PoweredFlight | None, duration: float
) -> Mapping[str, Floats]:
    """Power and energy of the PD law's flight at the nodes of the manoeuvre."""
    if baseline is None:
        return {}
    craft, account = manoeuvre.satellite.craft, baseline.energy
    output = 1.0 if craft.battery is None else float(craft.battery.output_efficiency)
    spent = baseline.wheel_power[0] + baseline.magnetorquer_power[0] + manoeuvre.load / output
    own = np.linspace(0.0, duration, len(spent))
    at = np.linspace(0.0, duration, manoeuvre.intervals + 1)
    found = {
        "net_power": baseline.solar_power[0] - spent,
        "net_energy": np.concatenate([[0.0], np.cumsum(account.net[0])]),
    }
    if np.isfinite(account.capacity):
        found["charge"] = account.charge[0]
    return {name: np.interp(at, own, values) for name, values in found.items()}


def phase_of(
    flown: Flown, family: str, baseline: PoweredFlight | None, free_time: bool = False
) -> tuple[Phase, Motion]:
    """Record of the best of the flown answers, and the state in which it ended."""
    manoeuvre, solved, flight, best = flown.manoeuvre, flown.solved, flown.flight, flown.best
    series = series_of(manoeuvre, flight, best)
    verdict = flown.verdict.pick(np.array([best]))
    flight_error = _flight_error(flown)
    certain = flight_error is None or flight_error.agreed
    reached = bool(verdict.reached[0]) and certain
    energy = energy_of_flight(manoeuvre, flight, best, baseline)
    step = float(flight.step[best])
    torque = flight.wheel_torque[best]
    craft = manoeuvre.satellite.craft
    decided, limit = solved.torque, craft.wheels.torque_limit
    if solved.dipole is not None and not torque.shape[1]:
        assert craft.magnetorquers is not None
        decided, limit = solved.dipole, craft.magnetorquers.dipole_limit
    active = np.abs(decided) > _ACTIVE * np.asarray(limit)
    penalised = manoeuvre.terminal != "reach"
    end, reference = manoeuvre.end, {}
    if end is not None:
        end = end.facing(np.asarray(series["q_ib"])[-1])
        axis = {} if end.boresight is None else {"boresight": end.boresight}
        reference = {"q_ib": end.q_ib, "omega_ib": end.omega_ib, **axis}
    duration = step * manoeuvre.intervals
    record = Phase(
        family=family,
        start_time=manoeuvre.start_time,
        step=step,
        controls=decided[best],
        series=series,
        reference=reference,
        errors={name: float(value[0]) for name, value in verdict.errors.items()},
        tolerances=verdict.tolerances,
        limit_violation=float(verdict.limit_violation[0]),
        margin_violation=float(verdict.margin_violation[0]),
        objective={
            "solar energy": -energy.solar,
            "actuation": energy.actuation,
            "loads": energy.loads,
        },
        l1_effort=float(np.abs(decided[best]).sum() * step),
        reached=reached,
        failure_reason=""
        if reached
        else failure_reason(
            verdict,
            Status(int(solved.status[best])),
            also=flown.notes,
            broken_margins=broken_margins(manoeuvre, flight, best),
            flight_error=flight_error,
        ),
        active=active[best].any(axis=1),
        starts=StartsRecord(
            status=solved.status,
            reached=flown.reached,
            active_intervals=active.any(axis=2).sum(axis=1),
            effort=np.asarray(np.abs(decided).sum(axis=(1, 2)) * flight.step),
            iterations=solved.iterations,
            shortfall=flown.verdict.shortfall,
            distinct_minima=flown.minima,
        ),
        flight_error=flight_error,
        wheel_bands=band_records(
            craft.wheels, flight.omega_bw[best], step, flight.speeds_passed[best]
        ),
        section=NetPower(
            energy=energy,
            claimed=float(solved.claimed[best]),
            start_energy=flight.energy.net_J,
            start_score=flown.score,
            share=flown.share,
            minima=flown.minima,
            refined=len(solved.status) if solved.refined is None else int(solved.refined.sum()),
            violation=float(solved.violation[best]),
            stationarity=float(solved.stationarity[best]),
            shadow=_shadow(manoeuvre.satellite, manoeuvre.start_time, duration),
            baseline=baseline_series(manoeuvre, baseline, duration),
            baseline_errors=_errors(manoeuvre, baseline),
            final_time_free=free_time,
            cost=-float(flown.score[best]) if free_time or penalised else None,
            by_dipoles=not torque.shape[1],
            saturated=_saturated(craft, series),
        ),
    )
    return record, Motion(*(series[name][-1] for name in ("q_ib", "omega_ib", "omega_bw")))


def _saturated(craft: Spacecraft, series: Mapping[str, Floats]) -> float | None:
    """Share of the time in which a dipole is at its limit, from its values at the nodes."""
    if craft.magnetorquers is None or not series["dipole"].any():
        return None
    full = np.abs(series["dipole"]) >= _FULL * np.asarray(craft.magnetorquers.dipole_limit)
    return float(full[:-1].any(axis=1).mean())


def _flight_error(flown: Flown) -> FlightError | None:
    """What the best answer's flight differs by from one with twice the steps; None without an end
    that it should reach."""
    manoeuvre, flight, best, given = flown.manoeuvre, flown.flight, flown.best, flown.solved.dipole
    if manoeuvre.end is None:
        return None
    finer = fly_with_twice_the_steps(
        manoeuvre,
        flight.wheel_torque[best],
        None if given is None else given[best],
        len(flight.q_ib),
    )
    end = manoeuvre.end
    return between(
        (flight.q_ib[best], flight.omega_ib[best]),
        (finer.q_ib[0, ::2], finer.omega_ib[0, ::2]),
        2 * steps_for(manoeuvre),
        {"attitude": end.attitude_tolerance, "rate": end.rate_tolerance},
    )


def _shadow(satellite: Satellite, start: float, duration: float) -> tuple[Eclipse, ...]:
    """Passages through the shadow in the time of a manoeuvre."""
    if satellite.orbit is None:
        return ()
    return eclipses(satellite.orbit, satellite.light, start, start + duration)


def _errors(manoeuvre: Manoeuvre, baseline: PoweredFlight | None) -> Mapping[str, float]:
    """Errors of the PD law's flight at its end."""
    if baseline is None:
        return {}
    errors = judge_flight(manoeuvre, baseline).errors
    return {name: float(value[0]) for name, value in errors.items()}
