"""Answers of a sparse slew to many targets, flown again until every flight is certain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jaxatt.environment.table import tabulate
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.targets.search import Rows, search_targets
from jaxatt.problems.pointing.watch import PathMonitor
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory
from jaxatt.simulation.flight_error import FlightErrors, fly_all_until_agreed


def answer_targets(task: SlewTask, targets: Floats, starts: int, seed: int) -> TargetAnswers:
    """Answer a slew for many targets q_ob (M, 4), in place of its own.

    starts : random ones for every target that two intervals do not reach.
    """
    many = task.aiming_at(targets)
    found = search_targets(many, starts, seed)
    controls = found.controls
    flown, flight = _flown(many, controls)
    verdict = many.judge(flown, controls)
    active = many.active(controls).any(axis=2).sum(axis=1)
    reached = verdict.reached & flight.agreed
    return TargetAnswers(
        reached,
        {
            "active_intervals": np.where(reached, active, np.nan),
            "l1_effort_Nms": np.where(reached, many.l1_effort(controls), np.nan),
            "attitude_error_deg": np.degrees(verdict.errors["attitude"]),
            "rate_error_rad_s": verdict.errors["rate"],
            "flight_error_deg": np.degrees(flight.attitude),
            "flight_error_rad_s": flight.rate,
        },
        controls,
        np.full(len(controls), many.step),
    )


def _flown(task: SlewTask, controls: Floats) -> tuple[Trajectory, FlightErrors]:
    """Flights of one answer to each target, and how wrong they can be."""
    flights, grid = task.flights, task.grid
    torque = task.wheel_torque(controls)

    def fly(rows: Rows, times: int) -> Trajectory:
        steps = flights.steps * times
        table = tabulate(flights.surroundings, grid.start_time, grid.step, grid.intervals, steps)
        monitor = PathMonitor(table, task.pointing, grid.start_time)
        return replace(flights, monitor=monitor).torques(torque[rows], watched=False)

    return fly_all_until_agreed(fly, len(controls), flights.steps, task.tolerances)
