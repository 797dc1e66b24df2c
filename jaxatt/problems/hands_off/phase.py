"""Record of a phase from the answer of a search: flown again, judged, labelled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.hands_off import sparsity
from jaxatt.problems.hands_off.record import FinalTimes, SparseSection, Valves
from jaxatt.problems.hands_off.search.candidates import Candidates
from jaxatt.problems.hands_off.search.quantise import MODES, Quantised, quantise
from jaxatt.problems.hands_off.search.search import Found
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Flown, SparseTask
from jaxatt.problems.hands_off.windows import forbidden_mask, window_mask
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.motor_torques import broken_motors
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.wheel_speeds import band_records, broken_speeds
from jaxatt.records.phase import Phase
from jaxatt.records.starts import StartsRecord
from jaxatt.records.wheel_bands import BandRecord
from jaxatt.records.wording import broken_limit, plural, uncertain_flight
from jaxatt.runtime.arrays import Floats

Fly = Callable[[Any, Floats], Flown]
"""(task, controls (1, N, b)) -> what an independent flight of them says."""


def phase_record(
    scenario: Scenario,
    task: SparseTask,
    found: Found,
    start_time: float,
    final_times: FinalTimes | None,
    fly: Fly,
) -> tuple[Phase, InitialState]:
    """Record of the best answer of a search, and the initial state of the next phase.

    fly : flies the answer again, see `Fly`.

    Where the answer does not reach (as the printed cost may prefer), the best that does reach
    stands beside it.
    """
    phase, state = _flown_phase(scenario, task, found, found.best, start_time, final_times, fly)
    if not phase.reached and found.reaching is not None:
        alternative, _ = _flown_phase(scenario, task, found, found.reaching, start_time, None, fly)
        if alternative.reached:
            phase = replace(phase, alternative=alternative)
    return phase, state


def _flown_phase(
    scenario: Scenario,
    task: SparseTask,
    found: Found,
    answer: Candidates,
    start_time: float,
    final_times: FinalTimes | None,
    fly: Fly,
) -> tuple[Phase, InitialState]:
    controls = answer.controls
    window = np.asarray(window_mask(scenario))
    forbidden = np.asarray(forbidden_mask(scenario))
    flown = fly(task, controls)
    verdict = flown.verdict
    xi = sparsity.complementarity_vector(controls[0], task.goal.epsilon, task.shared)
    product = np.abs(controls[0]) * (xi[:, None] if task.shared else xi)
    starts = found.starts
    record = StartsRecord(
        status=starts.status,
        reached=starts.verdict.reached,
        active_intervals=task.active(starts.controls).any(axis=2).sum(axis=1),
        effort=task.l1_effort(starts.controls),
        long_way=starts.sign < 0,
        iterations=starts.iterations,
        shortfall=starts.verdict.shortfall,
        distinct_minima=found.distinct_minima,
    )
    certain = flown.flight_error is None or flown.flight_error.agreed
    reached = bool(verdict.reached[0]) and certain
    active = np.any(task.active(controls[0]), axis=1)
    if flown.bias is not None:
        active |= flown.bias.added
    phase = Phase(
        family=scenario.family,
        start_time=start_time,
        step=task.step,
        controls=controls[0],
        series=flown.series,
        reference=flown.reference,
        errors={name: float(value[0]) for name, value in verdict.errors.items()},
        tolerances=verdict.tolerances,
        limit_violation=float(verdict.limit_violation[0]) + 0.0,  # no -0
        margin_violation=float(verdict.margin_violation[0]),
        objective={name: float(value[0]) for name, value in flown.cost.items()},
        l1_effort=float(task.l1_effort(controls)[0]),
        reached=reached,
        failure_reason="" if reached else _failure_reason(task, answer, flown),
        active=active,
        starts=record,
        pointing=flown.pointing,
        search_steps=task.substeps,
        flight_error=flown.flight_error,
        wheel_bands=_wheel_bands(task, flown),
        section=SparseSection(
            weight=np.asarray(task.arguments.weight),
            window=window,
            forbidden=forbidden,
            max_complementarity=float(product.max()),
            quantised=_valves(scenario, task, controls[0], float(answer.sign[0]), reached),
            final_times=final_times,
            bias=flown.bias,
        ),
    )
    return phase, flown.end


def _valves(
    scenario: Scenario, task: SparseTask, controls: Floats, sign: float, aims: bool
) -> tuple[Valves, ...]:
    """The answer with thrusters open or shut, as the scenario asks for and the other way."""
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
            np.asarray(q.flown.q_ob)[0],
            np.asarray(q.flown.omega_ob)[0],
            q.errors,
            q.reached,
            q.active,
            q.on_time,
            q.partly_open,
            q.opposed,
            "; ".join(_broken(q)),
        )
        for q in found
    )


def _broken(q: Quantised) -> list[str]:
    """What keeps a flight with valves open or shut from counting as reached, beside its errors."""
    words = [broken_limit(extreme) for extreme in q.extremes if not extreme.satisfied]
    return words if q.flight_error.agreed else [*words, uncertain_flight(q.flight_error)]


def _wheel_bands(task: SparseTask, flown: Flown) -> tuple[BandRecord, ...]:
    """How the wheels kept to the speeds that they avoid."""
    if flown.wheel_speeds is None or not isinstance(task, SlewTask):
        return ()
    return band_records(task.craft.wheels, *flown.wheel_speeds)


def _failure_reason(task: SparseTask, answer: Candidates, flown: Flown) -> str:
    """Sentence on the constraint that the closest answer violates."""
    saturated = task.saturated_intervals(answer.controls[0])
    binding: tuple[str, ...] = ()
    if saturated:
        binding = (f"the control limit binds in {saturated} of {task.intervals} intervals",)
    if task.substeps < task.needed_substeps:
        binding += (
            f"the search takes {plural(task.substeps, 'Runge-Kutta step')} an interval where "
            f"{task.needed_substeps} are needed: leave `substeps` out, or give as many",
        )
    if flown.bias is not None and flown.bias.share < 1.0:
        binding += (
            f"torque limits leave room for {100.0 * flown.bias.share:.3g} % of the change of the "
            "wheels' bias in all intervals: give more of them, or ask for a smaller bias",
        )
    speeds: list[str] = []
    if flown.wheel_speeds is not None and isinstance(task, SlewTask):
        wheels, torque = task.craft.wheels, task.wheel_torque(answer.controls[0])
        speeds = broken_speeds(wheels, *flown.wheel_speeds)
        speeds += broken_motors(wheels, torque, flown.wheel_speeds[0])
    status = Status(int(answer.status[0]))
    return failure_reason(
        flown.verdict, status, flown.pointing, binding, speeds, flown.flight_error
    )
