"""Quantisation: turn partly open thrusters into valves that are open or shut.

The relaxed answer says which valves open and for how much; `pulse-width` gives each the time that
this takes and corrects the times on exact flights, `interval` opens it for whole intervals or not
at all and searches for the combination that comes closest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.problems.hands_off.search.on_off_search import nearest_pattern
from jaxatt.problems.hands_off.search.pulse_widths import pulses_of, solve_widths
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.records.pointing import Extreme
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.flight import Trajectory
from jaxatt.simulation.flight_error import FlightError, fly_until_agreed
from jaxatt.simulation.pulses import Pulses, overlaps, partly_open

MODES = ("pulse-width", "interval")


@dataclass(frozen=True, eq=False)
class Quantised:
    """Flight of an answer with valves that are open or shut.

    mode : one of `MODES`.  pulses : the openings.  flown : the flight, (1, nodes, ...).
    flight_error : how wrong it can be.
    errors : "attitude" [rad] and "rate" [rad/s].  reached : whether within the task's tolerances.
    active : (N,), intervals with any torque.  on_time : (m,) [s], open time of each thruster.
    partly_open : sampled torques that are neither zero nor the limit.
    opposed : intervals in which opposed thrusters are open together.
    extremes : where it came nearest to breaking its cones and rate limits.
    """

    mode: str
    pulses: Pulses
    flown: Trajectory
    flight_error: FlightError
    errors: dict[str, float]
    reached: bool
    active: Flags
    on_time: Floats
    partly_open: int
    opposed: int
    extremes: tuple[Extreme, ...] = ()


def quantise(
    task: SlewTask, controls: Floats, sign: float, mode: str, aims: bool = True, seed: int = 0
) -> Quantised:
    """Make every thruster of an answer fully open or shut.

    controls : (N, b) [N m], the relaxed answer.  sign : the way round it aims.
    mode : "pulse-width" or "interval".  seed : of the search among whole intervals.
    aims : whether the answer reaches the target; one that does not, as the printed cost may prefer,
        keeps its own widths, or has them rounded, and is not steered anywhere else.
    """
    u = _unopposed(task, task.from_controls(controls))
    if not aims:
        first = task.craft.wheels.count
        whole = np.concatenate([u[:, :first], np.round(u[:, first:])], axis=1)
        return judge_pulses(task, pulses_of(task, u if mode == "pulse-width" else whole), mode)
    if mode == "pulse-width":
        return judge_pulses(task, _by_width(task, u, sign), mode)
    return judge_pulses(task, pulses_of(task, nearest_pattern(task, u, sign, seed)), mode)


def judge_pulses(task: SlewTask, pulses: Pulses, mode: str) -> Quantised:
    """Fly pulses with fine steps and judge the flight."""
    flown, flight_error = fly_until_agreed(
        lambda times: task.fly_pulses(pulses, times=times),
        task.flights.steps,
        task.tolerances,
        task.intervals,
    )
    errors = task.end_errors(flown.q_ob, flown.omega_ob)
    found = {name: float(error[0]) for name, error in errors.items()}
    limit = np.asarray(task.craft.thrusters.torque_limit)
    _, sampled = pulses.thrust(limit)
    extremes: tuple[Extreme, ...] = ()
    if task.watches:
        extremes = task.watch(flown).extremes(task.path_monitor.elapsed)
    arrived = all(error <= task.tolerances[name] for name, error in found.items())
    share = np.abs(pulses.wheel_torque) / np.asarray(task.craft.wheels.torque_limit)
    return Quantised(
        mode,
        pulses,
        flown,
        flight_error,
        found,
        arrived and flight_error.agreed and all(extreme.satisfied for extreme in extremes),
        np.any(pulses.on_time > 0.0, axis=1) | np.any(share > task.threshold, axis=1),
        pulses.on_time.sum(axis=0),
        partly_open(sampled, limit),
        overlaps(pulses, task.craft.thrusters.opposed),
        extremes,
    )


def _unopposed(task: SlewTask, u: Floats) -> Floats:
    """Remove from opposed thrusters the torque that cancels between them."""
    u = u.copy()
    thrusters, first = task.craft.thrusters, task.craft.wheels.count
    strength = np.linalg.norm(np.asarray(thrusters.distribution), axis=0) * np.asarray(
        thrusters.torque_limit
    )
    for i, j in thrusters.opposed:
        common = np.minimum(u[:, first + i] * strength[i], u[:, first + j] * strength[j])
        u[:, first + i] -= common / strength[i]
        u[:, first + j] -= common / strength[j]
    return u


def _by_width(task: SlewTask, u: Floats, sign: float) -> Pulses:
    """Pulses of any width that the valves allow; shorter ones are dropped or prolonged."""
    first = task.craft.wheels.count
    shortest = np.zeros(task.size)
    shortest[first:] = task.craft.thrusters.shortest_pulse / task.step
    used = np.abs(u).max(axis=1, keepdims=True) > 0.0
    wheel = np.arange(task.size) < first
    tried = []
    for share in (0.5, 0.0, 1.0):
        # Openings below this share of the shortest one are dropped.
        kept = np.where(wheel, used, u > np.maximum(share * shortest, 0.0))
        lower = np.where(kept, np.where(wheel, task.mounting.lower, shortest), 0.0)
        upper = np.where(kept, task.mounting.upper, 0.0)
        tried.append(solve_widths(task, u, sign, lower, upper))
        if tried[-1][1] < 1e-8:
            break
    return min(tried, key=lambda found: found[1])[0]
