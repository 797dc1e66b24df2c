"""Solve a turn in free time and record it as a phase."""

from __future__ import annotations

import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.optimize.status import Status
from jaxatt.problems.coasting import coasting_substeps
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.flown import flown_end, flown_series
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.motor_torques import broken_motors, motor_torque
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.time_optimal.arcs import Arcs
from jaxatt.problems.time_optimal.record import TimeOptimum
from jaxatt.problems.time_optimal.search import FreeTimeFound
from jaxatt.problems.time_optimal.starts import starts_of
from jaxatt.problems.time_optimal.switches import switch_times
from jaxatt.problems.time_optimal.task import ReorientationTask, TimeGoal
from jaxatt.problems.wheel_speeds import band_records, broken_speeds
from jaxatt.records.phase import Phase
from jaxatt.records.pointing import PointingRecord
from jaxatt.records.starts import StartsRecord
from jaxatt.simulation.flight import Trajectory, at_nodes
from jaxatt.simulation.flight_error import fly_until_agreed
from jaxatt.spacecraft.scale import IDLE_SHARE

_MEASURED = 4
"""Starts whose lengths of an interval say how many steps it needs."""


def build_time_task(
    scenario: Scenario,
    start: PhaseStart = PhaseStart(),  # noqa: B008
) -> ReorientationTask:
    """Build the task of a scenario of one of `TIME_KINDS`."""
    assert scenario.vehicle is not None
    horizon = scenario.horizon
    goal = TimeGoal(
        scenario.objective.effort_weight,
        scenario.transcription.attitude,
        scenario.transcription.integration,
        horizon.substeps,
        horizon.shortest,
        horizon.longest,
    )
    craft, target = scenario.vehicle, scenario.targets[start.index]
    initial, count = start.state or scenario.initial, horizon.intervals
    task = ReorientationTask(craft, initial, target, count, goal, scenario.pointing)
    if not task.measures_substeps or task.at_target:
        return task
    few = starts_of(task, _MEASURED, scenario.solver.seed)
    step = float(np.median(few.step))
    return task.with_substeps(coasting_substeps(craft, initial, target, step, count))


def time_record(
    scenario: Scenario,
    start_time: float,
    task: ReorientationTask,
    found: FreeTimeFound,
    arcs: Arcs | None,
) -> tuple[Phase, InitialState]:
    """The best turn with how every start ended, flown again, and where it ended.

    start_time : [s] since the scenario's start.  arcs : its resolved switches, if there are any.
    """
    best, n = found.best, task.craft.wheels.count
    torque, step = found.controls[best], float(found.step[best])
    task, between = task.with_substeps(found.substeps), task.nodes_between
    count = task.intervals
    path, flight_error = fly_until_agreed(
        lambda times: task.fly(torque[None], np.array([step]), times=times),
        task.flight_steps,
        task.tolerances,
        count * between,
    )
    verdict, flown = task.judge(path, torque[None], np.array([step])), at_nodes(path, between)
    pointing = _pointing(task, found, path)
    reached = bool(verdict.reached[0]) and flight_error.agreed
    effort = float(task.quadratic_effort(torque, np.asarray(step)))
    series = flown_series(flown)
    wheels = task.craft.wheels
    speeds = np.asarray(path.omega_bw)[0], float(task.between_nodes(step))
    if n:
        series["torque_wheels"] = torque[:, :n]
        if not wheels.motors.ideal:
            series["torque_motors"] = motor_torque(wheels, torque[:, :n], speeds[0])
        series["torque_body"] = torque[:, :n] @ np.asarray(task.craft.wheels.axes).T
    if task.craft.thrusters.count:
        series["torque_thrusters"] = torque[:, n:]
    reference = task.target.facing(np.asarray(flown.q_ob)[0, task.intervals]).reference()
    if task.target.wheel_bias is not None:
        reference["wheel_bias"] = task.target.wheel_bias
    names = task.craft.wheels.names + tuple(
        f"thruster {i + 1}" for i in range(task.craft.thrusters.count)
    )
    thrusters = task.craft.thrusters
    upper = np.concatenate([np.asarray(wheels.torque_limit), np.asarray(thrusters.torque_limit)])
    lower = np.concatenate([-np.asarray(wheels.torque_limit), np.zeros(thrusters.count)])
    active = np.abs(found.controls) > IDLE_SHARE * upper
    switches = switch_times(torque, step * np.arange(count + 1.0), lower, upper)
    if arcs is not None:
        switches = arcs.switches
    final = count * step
    record = Phase(
        family=scenario.family,
        start_time=start_time,
        step=step,
        controls=torque,
        series=series,
        reference=reference,
        errors={name: float(value[0]) for name, value in verdict.errors.items()},
        tolerances=verdict.tolerances,
        limit_violation=float(verdict.limit_violation[0]),
        margin_violation=float(verdict.margin_violation[0]),
        objective={"time": final, "effort": scenario.objective.effort_weight * effort},
        l1_effort=float(np.abs(torque).sum() * step),
        reached=reached,
        failure_reason=""
        if reached
        else failure_reason(
            verdict,
            Status(int(found.status[best])),
            pointing,
            broken_margins=[
                *broken_speeds(wheels, *speeds),
                *broken_motors(wheels, torque[:, :n], speeds[0]),
            ],
            flight_error=flight_error,
        ),
        active=active[best].any(axis=1),
        starts=StartsRecord(
            status=found.status,
            reached=found.reached,
            active_intervals=active.any(axis=2).sum(axis=1),
            effort=np.asarray(np.abs(found.controls).sum(axis=(1, 2)) * found.step),
            long_way=found.long_way,
            iterations=found.iterations,
            shortfall=found.verdict.shortfall,
            distinct_minima=found.minima,
        ),
        pointing=pointing,
        search_steps=found.substeps,
        flight_error=flight_error,
        wheel_bands=band_records(wheels, *speeds),
        section=TimeOptimum(
            effort_weight=scenario.objective.effort_weight,
            cost=float(found.cost[best]),
            actuators=names,
            switch_times=switches,
            torque_share=float((np.abs(torque) / upper).max()),
            violation=float(found.violation[best]),
            stationarity=float(found.stationarity[best]),
            minima=found.minima,
            share=found.share,
            own_error=float(found.own_error[best]),
            start_costs=found.cost,
            start_times=count * found.step,
            attitude=scenario.transcription.attitude,
            integration=scenario.transcription.integration,
            resolved_time=None if arcs is None else arcs.final_time,
        ),
    )
    return record, flown_end(flown, count)


def _pointing(
    task: ReorientationTask, found: FreeTimeFound, flown: Trajectory
) -> PointingRecord | None:
    """Record of cones and rate limits along the best answer's flight, with nodes between."""
    if not task.pointing:
        return None
    watch, between = task.watch(flown), task.nodes_between
    count = task.intervals * between
    times = np.asarray(float(found.step[found.best]) / between * np.arange(count + 1))
    directions = np.broadcast_to(task.directions, (count + 1, *task.directions.shape))
    q = np.broadcast_to(np.asarray(flown.q_ob[0])[:, None], (*directions.shape[:2], 4))
    fixed = np.reshape([cone.boresight for cone in task.pointing.cones], (1, -1, 3))
    return PointingRecord(
        time=times,
        angles=watch.angles[0],
        boresights=np.asarray(quaternion.rotate(q, np.broadcast_to(fixed, directions.shape))),
        directions=directions,
        extremes=watch.extremes(times),
        constraint_margin=found.constraint_margin[:-1],
    )
