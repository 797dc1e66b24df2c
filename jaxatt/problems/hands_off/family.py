"""The family of sparse control of a spacecraft, with wheels and thrusters."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from jaxatt.problems.family import Family, PhaseStart, SearchOptions
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.certificate import PhaseCertificate
from jaxatt.problems.hands_off.enumerate_supports import certify_support
from jaxatt.problems.hands_off.file_format import FORMAT
from jaxatt.problems.hands_off.phase import phase_record
from jaxatt.problems.hands_off.phase_search import Build, search_phase
from jaxatt.problems.hands_off.reading.scenario import read_hands_off
from jaxatt.problems.hands_off.record import FinalTimes
from jaxatt.problems.hands_off.report.sections import HANDS_OFF
from jaxatt.problems.hands_off.search.search import Found
from jaxatt.problems.hands_off.sensitive import sensitive_support
from jaxatt.problems.hands_off.slew.flight import fly_slew
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.sparse_program import DecidedBy
from jaxatt.problems.hands_off.targets.answers import answer_targets
from jaxatt.problems.hands_off.task import Flown, SparseTask
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.records.phase import Phase
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report


class SparseAnswer(NamedTuple):
    """Outcome of the search of one phase; tried : final times, where it is free."""

    task: SparseTask
    found: Found
    tried: FinalTimes | None


class SparseFamily(Family):
    """Base of the families of sparse control, which differ in the system that is controlled."""

    kinds = FORMAT.kinds

    def build(self, scenario: Scenario, start: PhaseStart) -> Build:
        """Function that builds the task of a phase, at the scenario's final time or another."""
        raise NotImplementedError

    def fly(self, task: Any, controls: Floats) -> Flown:
        """Fly controls (1, N, b) of a task again and judge the flight."""
        raise NotImplementedError

    def check(self, scenario: Scenario, options: SearchOptions) -> None:
        """Leave guesses and inner minimisers to the search, which knows the task."""

    def search(
        self, scenario: Scenario, start: PhaseStart, options: SearchOptions, report: Report | None
    ) -> SparseAnswer:
        build = self.build(scenario, start)
        return SparseAnswer(*search_phase(scenario, build, options.guess, options.inner, report))

    def judge(
        self, scenario: Scenario, start: PhaseStart, found: SparseAnswer
    ) -> tuple[Phase, InitialState]:
        return phase_record(scenario, found.task, found.found, start.time, found.tried, self.fly)

    def check_certifiable(self, scenario: Scenario) -> None:
        if scenario.objective.kind == "l1":
            super().check_certifiable(scenario)
        _refuse_bias(scenario, "a certificate is")
        reaching = replace(scenario, objective=replace(scenario.objective, terminal="reach"))
        task = self.build(reaching, PhaseStart())(reaching)
        if task.system.decided_by in (DecidedBy.STAGES, DecidedBy.LAGRANGIAN) or task.watches:
            raise ScenarioError(
                f"{scenario.name}: has limits along the way, under which supports cannot be tried "
                "one by one; certify it without what it has of speed_limit_rad_s under "
                "[vehicle.wheels], [[keep_out]], [[keep_in]] and [limits]"
            )

    def certify(
        self,
        scenario: Scenario,
        start: PhaseStart,
        phase: Phase,
        most: int,
        seed: int,
        report: Report | None,
    ) -> PhaseCertificate:
        build = self.build(scenario, start)
        task = build(scenario, enforce_speed_limits=False, final_time=phase.final_time)
        return certify_support(task, phase, most, seed, report)

    def sensitive(
        self, scenario: Scenario, start: PhaseStart, found: SparseAnswer
    ) -> SensitiveAnswer:
        _refuse_bias(scenario, "sensitivities are")
        build = self.build(scenario, start)
        task = found.task.keeping_path_limits_of(found.task)
        time = None if not scenario.horizon.free else task.final_time

        def again(scenario: Scenario) -> SparseTask:
            other = build(scenario, enforce_speed_limits=task.limits_speeds, final_time=time)
            return other.keeping_path_limits_of(task)

        return sensitive_support(scenario, task, found.found, again)

    def extra(self, scenario: Scenario, found: Sequence[SparseAnswer]) -> Mapping[str, Any]:
        if scenario.objective.terminal != "penalty":
            return {}
        return {"do_nothing_cost": sum(answer.found.do_nothing_cost or 0.0 for answer in found)}


class HandsOff(SparseFamily):
    """Family of maximum hands-off, moving hands-off and L1 control of a spacecraft."""

    name = FORMAT.name
    systems = FORMAT.systems
    tables = FORMAT.tables
    sections = HANDS_OFF
    mapped = ("active_intervals", "l1_effort_Nms")

    def read(
        self, document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
    ) -> Scenario:
        return read_hands_off(document, origin, folder, faults)

    def build(self, scenario: Scenario, start: PhaseStart) -> Build:
        return functools.partial(
            build_slew, phase=start.index, initial_state=start.state, start_time=start.time
        )

    def fly(self, task: SlewTask, controls: Floats) -> Flown:
        return fly_slew(task, controls)

    def answer_targets(self, scenario: Scenario, targets: Floats) -> TargetAnswers | None:
        several = scenario.horizon.free or scenario.waypoint is not None or _biased(scenario)
        if several or scenario.objective.kind != "l0":
            return None
        # Nothing is asked of what comes after the end.
        task = build_slew(replace(scenario, horizon=replace(scenario.horizon, coast_intervals=0)))
        batched = task.system.decided_by is DecidedBy.CONDENSED and not task.in_motion
        if not batched or task.watches or task.goal.terminal != "reach" or not task.shared:
            return None
        return answer_targets(task, targets, scenario.solver.starts, scenario.solver.seed)


def _biased(scenario: Scenario) -> bool:
    return any(target.wheel_bias is not None for target in scenario.targets)


def _refuse_bias(scenario: Scenario, what: str) -> None:
    if _biased(scenario):
        raise ScenarioError(
            f"{scenario.name}: [target] wheel_bias_rad_s: {what} of the torques that turn the "
            "body, to which those for the bias are added afterwards; drop it"
        )
