"""Verdict of fine flights on answers to a manoeuvre in free time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jaxatt.attitude import errors
from jaxatt.problems.net_power.flight import PoweredFlight, fly_many
from jaxatt.problems.net_power.found import Flown, Solved, ranked
from jaxatt.problems.net_power.magnetic.along_field import field_note
from jaxatt.problems.net_power.magnetic.answers import Answers
from jaxatt.problems.net_power.magnetic.search import FrontFound
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.problems.net_power.manoeuvre import End, Manoeuvre
from jaxatt.problems.verdict import Verdict
from jaxatt.runtime.arrays import Floats


def fly_found(found: FrontFound, k: int = 0) -> Flown:
    """Fly the best answer that goes back to each start finely, and judge all of them.

    k : index of the weight of time.
    """
    task, answers = found.task, found.of_starts(k)
    manoeuvres = fixed(task, answers.final_time)
    flight = fly_answers(task, answers, manoeuvres)
    verdict = judge_answers(task, manoeuvres, flight)
    cost = flown_cost(task, manoeuvres, flight, float(found.time_weight[k]))
    m, final = task.manoeuvre, answers.final_time
    solved = Solved(
        torque=flight.wheel_torque,
        dipole=dipoles(task, answers),
        claimed=answers.claimed * final,
        status=answers.status,
        violation=answers.violation,
        stationarity=answers.stationarity,
        iterations=answers.iterations,
    )
    earned = np.abs(flight.energy.solar_J) / (final if m.cost == "mean-power" else 1.0)
    scale, weighed = float(np.nanmax(earned)), m.terminal == "penalty"
    flown = ranked(manoeuvres[0], solved, flight, verdict, -cost, scale, weighed)
    best = flown.best
    notes: tuple[str, ...] = ()
    if not flown.reached[best]:
        note = field_note(task, float(final[best]), flight.q_ib[best, -1])
        notes = (note,) if note else ()
    return replace(flown, manoeuvre=manoeuvres[best], notes=notes)


def dipoles(task: MagneticTask, answers: Answers) -> Floats:
    """Dipoles (A, N, 3) [A m^2] of answers."""
    return np.clip(answers.u, -1.0, 1.0) * task.dipole_limit


def fixed(task: MagneticTask, final_time: Floats) -> list[Manoeuvre]:
    """Manoeuvres of fixed lengths (A,) [s], for the flights."""
    m = task.manoeuvre
    found = []
    for final in final_time:
        pose = task.target_at(float(final))
        end = End(pose.q_ib, pose.omega_ib, m.target.attitude_tolerance, m.target.rate_tolerance)
        found.append(
            Manoeuvre(
                satellite=m.satellite,
                start=m.start,
                end=end,
                start_time=m.start_time,
                duration=float(final),
                intervals=m.intervals,
                load=m.load,
                terminal=m.terminal,
                charge=m.charge,
            )
        )
    return found


def fly_answers(task: MagneticTask, answers: Answers, manoeuvres: list[Manoeuvre]) -> PoweredFlight:
    """Fly answers (A,), each in its own final time."""
    count = len(answers.u)
    still = np.zeros((count, task.manoeuvre.intervals, 0))
    return fly_many(manoeuvres, np.arange(count), still, dipoles(task, answers))


def judge_answers(
    task: MagneticTask, manoeuvres: list[Manoeuvre], flight: PoweredFlight
) -> Verdict:
    """Judge attitude and rate at the end of each flight, and the dipoles' limits."""
    angle, rate = end_errors(manoeuvres, flight)
    target = task.manoeuvre.target
    over = (flight.strongest - task.dipole_limit).max(axis=1)
    return Verdict(
        {"attitude": angle, "rate": rate},
        {"attitude": target.attitude_tolerance, "rate": target.rate_tolerance},
        np.where(np.isfinite(over), np.maximum(over, 0.0), np.inf),
        np.zeros(len(over)),
        float(task.dipole_limit.min()),
    )


def end_errors(manoeuvres: list[Manoeuvre], flight: PoweredFlight) -> tuple[Floats, Floats]:
    """Errors of attitude [rad] and rate [rad/s] at the ends of flights, (A,) each."""
    ends = [one.end for one in manoeuvres]
    q = np.stack([end.q_ib for end in ends if end is not None])
    omega = np.stack([end.omega_ib for end in ends if end is not None])
    angle = np.asarray(errors.angle(q, flight.q_ib[:, -1]))
    rate = np.linalg.norm(flight.omega_ib[:, -1] - omega, axis=1)
    return np.nan_to_num(angle, nan=np.inf), np.nan_to_num(rate, nan=np.inf)


def flown_cost(
    task: MagneticTask, manoeuvres: list[Manoeuvre], flight: PoweredFlight, time_weight: float
) -> Floats:
    """Cost (6.2a) of flights, or that by energy, (A,)."""
    m = task.manoeuvre
    final = np.array([one.duration for one in manoeuvres])
    energy = flight.energy.net_J
    cost = time_weight * final - (energy / final if m.cost == "mean-power" else energy)
    if m.terminal == "penalty":
        angle, rate = end_errors(manoeuvres, flight)
        cost = cost + m.attitude_weight * (1.0 - np.cos(0.5 * angle)) + m.rate_weight * rate**2
    return np.where(np.isfinite(cost), cost, np.inf)
