"""From the answer of a search to a phase: flown again, judged, labelled."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from jaxatt import scenarios
from jaxatt.optimize.status import Status
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.hands_off import sparsity
from jaxatt.problems.hands_off.record import FinalTimes, SparseSection, Valves
from jaxatt.problems.hands_off.search.candidates import Candidates
from jaxatt.problems.hands_off.search.quantise import MODES, quantise
from jaxatt.problems.hands_off.search.search import Found
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Task
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.toy.task import ToyTask
from jaxatt.records.phase import Phase
from jaxatt.records.pointing import PointingRecord
from jaxatt.records.starts import StartsRecord
from jaxatt.records.wording import broken_limit, limit_label
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory


def phase_record(
    scenario: scenarios.Scenario,
    task: Task,
    found: Found,
    start_time: float,
    final_times: FinalTimes | None = None,
) -> tuple[Phase, InitialState | None]:
    """The best answer of a search as a labelled phase, and where the next phase begins.

    Where the answer does not reach (as the printed cost may prefer), the best that does reach
    stands beside it.
    """
    phase, state = _flown_phase(scenario, task, found, found.best, start_time, final_times)
    if not phase.reached and found.reaching is not None:
        alternative, _ = _flown_phase(scenario, task, found, found.reaching, start_time, None)
        phase = replace(phase, alternative=alternative)
    return phase, state


def _flown_phase(
    scenario: scenarios.Scenario,
    task: Task,
    found: Found,
    answer: Candidates,
    start_time: float,
    final_times: FinalTimes | None,
) -> tuple[Phase, InitialState | None]:
    controls = answer.controls
    window = np.asarray(scenarios.window_mask(scenario))
    forbidden = np.asarray(scenarios.forbidden_mask(scenario))
    state = pointing = None
    if isinstance(task, SlewTask):
        flown = task.fly(controls)
        pointing = _pointing(task, flown)
        verdict, cost = task.judge(flown, controls), task.cost(flown, controls)
        end = task.intervals
        state = InitialState(
            *(np.asarray(part[0, end]) for part in (flown.q_ob, flown.omega_ob, flown.omega_bw))
        )
        series = {
            "q_ob": np.asarray(flown.q_ob[0]),
            "omega_ob": np.asarray(flown.omega_ob[0]),
            "omega_ib": np.asarray(flown.omega_ib[0]),
            "omega_bw": np.asarray(flown.omega_bw[0]),
        }
        if task.craft.wheels.count:
            series["torque_body"] = task.body_torque(controls[0])
            series["torque_wheels"] = task.wheel_torque(controls[0])
        if task.craft.thrusters.count:
            series["torque_thrusters"] = task.thrust(controls[0])
        reference = {"q_ob": task.target.q_ob, "omega_ob": task.target.omega_ob}
        if task.waypoint is not None:
            reference["waypoint"] = task.waypoint.q_ob
    else:
        assert isinstance(task, ToyTask)
        verdict, cost = task.verify(controls)
        series = {"state": task.fly(controls)[0], "control": controls[0]}
        reference = {"state": np.asarray(task.parameters.target)}
    xi = sparsity.complementarity_vector(controls[0], task.goal.epsilon, task.shared)
    product = np.abs(controls[0]) * (xi[:, None] if task.shared else xi)
    starts = found.starts
    record = StartsRecord(
        status=starts.status,
        reached=starts.verdict.reached,
        active_intervals=(np.abs(starts.controls) > task.threshold).any(axis=2).sum(axis=1),
        effort=task.effort(starts.controls),
        long_way=starts.sign < 0,
        iterations=starts.iterations,
        shortfall=starts.verdict.shortfall,
        distinct_minima=found.distinct_minima,
    )
    reached = bool(verdict.reached[0])
    phase = Phase(
        family="hands-off" if isinstance(task, SlewTask) else "toy",
        start_time=start_time,
        step=task.step,
        controls=controls[0],
        series=series,
        reference=reference,
        errors={name: float(value[0]) for name, value in verdict.errors.items()},
        tolerances=verdict.tolerances,
        limit_violation=float(verdict.limit_violation[0]),
        margin_violation=float(verdict.margin_violation[0]),
        objective={name: float(value[0]) for name, value in cost.items()},
        effort=float(task.effort(controls)[0]),
        reached=reached,
        failure_reason="" if reached else _failure_reason(task, answer, pointing),
        active=(np.abs(controls[0]) > task.threshold).any(axis=1),
        starts=record,
        pointing=pointing,
        section=SparseSection(
            weight=np.asarray(task.arguments.weight),
            window=window,
            forbidden=forbidden,
            max_complementarity=float(product.max()),
            quantised=_valves(scenario, task, controls[0], float(answer.sign[0]), reached),
            final_times=final_times,
        ),
    )
    return phase, state


def _pointing(task: SlewTask, flown: Trajectory) -> PointingRecord | None:
    """What a flight (S = 1) says of cones and rate limits."""
    if not task.pointing:
        return None
    path_monitor, times = task.path_monitor, task.path_monitor.elapsed
    constraint_margin = (
        np.zeros(len(task.pointing.cones) + 1)
        if task.constraint_margin is None
        else task.constraint_margin
    )
    return PointingRecord(
        time=times,
        angles=path_monitor.watch(flown).angles[0],
        boresights=path_monitor.boresights(flown),
        directions=path_monitor.directions,
        extremes=task.watch(flown).extremes(times),
        constraint_margin=constraint_margin[:-1],
    )


def constraint_margin_notes(phase: Phase) -> tuple[str, ...]:
    """Which cones the search of a phase took stricter than they are, in words."""
    record = phase.pointing
    if record is None:
        return ()
    return tuple(
        f"{limit_label(extreme.kind, extreme.name)} was taken {math.degrees(margin):.2g} deg "
        "stricter, so that the way between the nodes keeps to it"
        for extreme, margin in zip(record.extremes, record.constraint_margin, strict=False)
        if margin > 0.0
    )


def _valves(
    scenario: scenarios.Scenario, task: Task, controls: Floats, sign: float, aims: bool
) -> tuple[Valves, ...]:
    """The answer with thrusters open or shut, as the scenario wants it and the other way."""
    wanted = scenario.control.quantisation
    if wanted not in MODES or not isinstance(task, SlewTask):
        return ()
    modes = (wanted, *(mode for mode in MODES if mode != wanted))
    found = (quantise(task, controls, sign, mode, aims, scenario.solver.seed) for mode in modes)
    return tuple(
        Valves(
            q.mode,
            q.pulses.opens,
            q.pulses.shuts,
            np.asarray(q.flown.q_ob),
            np.asarray(q.flown.omega_ob),
            q.errors,
            q.reached,
            q.active,
            q.on_time,
            q.partly_open,
            q.opposed,
            "; ".join(broken_limit(extreme) for extreme in q.extremes if not extreme.satisfied),
        )
        for q in found
    )


def _failure_reason(task: Task, answer: Candidates, pointing: PointingRecord | None = None) -> str:
    """Which constraint is in the way of the closest answer, in words."""
    saturated = task.saturated_intervals(answer.controls[0])
    binding: tuple[str, ...] = ()
    if saturated:
        binding = (f"the control limit binds in {saturated} of {task.intervals} intervals",)
    return failure_reason(answer.verdict, Status(int(answer.status[0])), pointing, binding)
