"""Interface of a family of problems: read, search, fly, judge and report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.front import Front, FrontRequest
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.schema import Tables
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sections import Sections
from jaxatt.problems.sensitive import OptimalObjective, SensitiveAnswer
from jaxatt.records.phase import Phase
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report


@dataclass(frozen=True, eq=False)
class PhaseStart:
    """Beginning of one phase of a scenario.

    index : of the phase, from zero.  time : [s] since the scenario's start.
    state : the flown end of the phase before; None where the scenario itself begins.
    """

    index: int = 0
    time: float = 0.0
    state: InitialState | None = None

    def following(self, phase: Phase, end: InitialState | None) -> PhaseStart:
        """Where the next phase begins: at the flown end of this one."""
        return PhaseStart(self.index + 1, self.time + phase.final_time, end)


@dataclass(frozen=True, eq=False)
class Improved:
    """All phases after they were improved together.

    phases, found : as `judge` and `search` returned them, each from the flown end of the one
    before.  extra : numbers on the improvement for the result, see `Family.extra`.
    """

    phases: tuple[Phase, ...]
    found: tuple[Any, ...]
    extra: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class SearchOptions:
    """Options of `solve` beyond the scenario.

    guess : name of a first guess, or controls (N, b).  inner : name of an inner minimiser.
    """

    guess: str | Floats = "pulses"
    inner: str = "auto"

    @property
    def default(self) -> bool:
        """Whether all options have their defaults."""
        return isinstance(self.guess, str) and (self.guess, self.inner) == ("pulses", "auto")


class Family(ABC):
    """A family of problems: its name, what it reads, and the steps from a scenario to its record.

    name : as records carry it.
    systems : values of `system` in a scenario that it answers to, e.g. "spacecraft".
    kinds : values of `objective.kind` that it answers to; the first is the default.
    tables : name of a TOML table -> keys it may hold, with their types, ranges and meanings.
    sections : what it adds to a report.
    mapped : names in `summary.json` of what a map over many targets shows, best first; none where
        no attitude is aimed at.

    A new family is a subclass in a folder of its own and a line in `jaxatt.problems.registry`, or a
    call of `register` from outside the package.  Nothing else asks which family an answer is from.
    """

    name: str
    systems: tuple[str, ...]
    kinds: tuple[str, ...]
    tables: Tables
    sections: Sections
    mapped: tuple[str, ...] = ()

    @abstractmethod
    def read(
        self, document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
    ) -> Scenario:
        """Read and check the scenario of a TOML document.

        origin : what messages call the file.  folder : where files that it names are looked up.
        faults : those that were found before; `faults.refuse()` raises them, where reading is not
        to go on with the parts that have none.
        Raises `ScenarioError`, which names table, key, value, what is allowed and how to mend it.
        """

    def phases(self, scenario: Scenario) -> int:
        """Number of optimisations, each beginning at the flown end of the one before."""
        return len(scenario.targets)

    def check(self, scenario: Scenario, options: SearchOptions) -> None:
        """Refuse options that the search does not support, with a `ValueError`."""
        if not options.default:
            raise ValueError(
                f"guess, inner: kind = {scenario.objective.kind} has starts and a method of its "
                "own; leave them out"
            )

    @abstractmethod
    def search(
        self, scenario: Scenario, start: PhaseStart, options: SearchOptions, report: Report | None
    ) -> Any:
        """Solve one phase from many starts; the return value goes to `judge`.

        report : called by the host with (stage, starts ended) between chunks of work.
        """

    def search_many(self, scenarios: Sequence[Scenario]) -> Sequence[Any] | None:
        """Search scenarios of one phase together, each as `search` returns it; None to refuse.

        For sweeps, whose scenarios differ in a few values, where it takes less time than one search
        after the other.
        """
        return None

    @abstractmethod
    def judge(
        self, scenario: Scenario, start: PhaseStart, found: Any
    ) -> tuple[Phase, InitialState]:
        """Fly the answer of a search again with finer steps; return record and flown end."""

    def improve(
        self,
        scenario: Scenario,
        phases: Sequence[Phase],
        found: Sequence[Any],
        report: Report | None,
    ) -> Improved | None:
        """Improve all phases together after they were solved in sequence; None to keep those.

        phases, found : what `judge` and `search` returned for each.
        """
        return None

    def front(self, scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
        """Best answers for many values of what is weighed against the gain, solved together.

        Raises `ScenarioError` where there is nothing to weigh.
        """
        raise ScenarioError(
            f'{scenario.name}: objective.kind = "{scenario.objective.kind}" gains no energy that '
            'could be weighed against time or error; choose a manoeuvre of kind "net-power"'
        )

    def answer_targets(self, scenario: Scenario, targets: Floats) -> TargetAnswers | None:
        """The best answer to each of many targets (M, 4) in batches over all of them.

        targets : as `Target.q_ob`, in place of the scenario's own; its other settings stay.
        None where they have to be solved one by one.
        """
        return None

    def measure(self, scenario: Scenario) -> str:
        """Name in `summary.json` of the objective that `sensitive` differentiates; empty if none.

        A design minimises it, or a number under a limit of it.
        """
        return ""

    def search_targets(
        self,
        scenario: Scenario,
        targets: Floats,
        near: Sequence[Any] | None,
        report: Report | None,
    ) -> Sequence[Any]:
        """Search for each of many targets (M, 4), each as `search` returns it for that target.

        near : answers for the same targets of a scenario that differs little, from which a family
        may go on in place of the scenario's own starts.
        """
        options = SearchOptions()
        return [self.search(scenario.aiming_at(q), PhaseStart(), options, report) for q in targets]

    def check_certifiable(self, scenario: Scenario) -> None:
        """Refuse scenarios whose minimum is not shown by trying supports, with `ScenarioError`."""
        raise ScenarioError(
            f'objective.kind = "{scenario.objective.kind}": its minimum is not a matter of '
            'supports; certify "l0" or "moving-l0"'
        )

    def certify(
        self,
        scenario: Scenario,
        start: PhaseStart,
        phase: Phase,
        most: int,
        seed: int,
        report: Report | None,
    ) -> Any:
        """Evidence on the answer of a phase, for scenarios that `check_certifiable` passes."""
        raise NotImplementedError

    def sensitive(self, scenario: Scenario, start: PhaseStart, found: Any) -> SensitiveAnswer:
        """The answer of a phase, polished, as a function of what it depends on.

        found : as `search` returned it.  Raises `ScenarioError` where it has no sensitivities.
        """
        raise ScenarioError(
            f'{scenario.name}: answers of objective.kind = "{scenario.objective.kind}" have no '
            "sensitivities yet; write the problem with jaxatt.transcribe, whose answers have"
        )

    def objective(self, scenario: Scenario, start: PhaseStart, found: Any) -> OptimalObjective:
        """The objective alone of such an answer, for designs."""
        sensitive = self.sensitive(scenario, start, found)
        answer = sensitive.optimum.answer
        return OptimalObjective(
            answer.objective,
            answer.args,
            sensitive.arguments,
            lambda along: np.asarray(answer.moves(along).objective),
        )

    def extra(self, scenario: Scenario, found: Sequence[Any]) -> Mapping[str, Any]:
        """Numbers of a whole result that belong to no phase, from what the searches returned."""
        return {}
