"""The family of manoeuvres and plans that earn energy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jaxatt.problems.family import Family, Improved, PhaseStart, SearchOptions
from jaxatt.problems.front import Front, FrontRequest
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.answers import Answers, judged, searched
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.file_format import FORMAT
from jaxatt.problems.net_power.front.front import net_power_front
from jaxatt.problems.net_power.improve import improved
from jaxatt.problems.net_power.reading.scenario import read_net_power
from jaxatt.problems.net_power.report.sections import NET_POWER
from jaxatt.problems.net_power.sensitive import sensitive_manoeuvre
from jaxatt.problems.net_power.targets import answer_targets
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.records.phase import Phase
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report


class NetPower(Family):
    """Family of manoeuvres that earn the most net energy, one by one or as a plan of tasks."""

    name = FORMAT.name
    systems = FORMAT.systems
    kinds = FORMAT.kinds
    tables = FORMAT.tables
    sections = NET_POWER
    mapped = ("energy.net_J", "energy.gain_J")

    def read(
        self, document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
    ) -> Scenario:
        return read_net_power(document, origin, folder, faults)

    def phases(self, scenario: Scenario) -> int:
        """One for a manoeuvre, one for each task of a plan."""
        return max(1, len(options_of(scenario).tasks))

    def search(
        self, scenario: Scenario, start: PhaseStart, options: SearchOptions, report: Report | None
    ) -> Answers:
        return searched(scenario, start, report)

    def judge(
        self, scenario: Scenario, start: PhaseStart, found: Answers
    ) -> tuple[Phase, InitialState]:
        return judged(scenario, start, found)

    def improve(
        self,
        scenario: Scenario,
        phases: Sequence[Phase],
        found: Sequence[Any],
        report: Report | None,
    ) -> Improved | None:
        """Improve a plan over its tasks' boundaries."""
        return improved(scenario, phases, found, report)

    def front(self, scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
        """Energy against the length of a manoeuvre, or against the error at its end."""
        return net_power_front(scenario, asked, report)

    def answer_targets(self, scenario: Scenario, targets: Floats) -> TargetAnswers | None:
        """Most energy to each target, with wheels and in a time that is given."""
        alone = not options_of(scenario).tasks and len(scenario.targets) == 1
        if not alone or scenario.horizon.free or scenario.objective.terminal != "reach":
            return None
        return answer_targets(scenario, targets)

    def sensitive(self, scenario: Scenario, start: PhaseStart, found: Answers) -> SensitiveAnswer:
        return sensitive_manoeuvre(scenario, start, found)
