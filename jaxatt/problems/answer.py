"""The answer to a scenario as a plain record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from jaxatt.problems.scenario import Scenario
from jaxatt.records.phase import Phase


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to a scenario: one phase, or several flown one after another.

    status : "reached" or "not reached".  time : seconds spent on "compile", "solve", "verify".
    """

    scenario: Scenario
    phases: tuple[Phase, ...]
    seed: int
    time: Mapping[str, float]
    device: str
    precision: str
    versions: Mapping[str, str]
    notes: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)

    @property
    def legs(self) -> tuple[Phase, ...]:
        """The phases, by their earlier name."""
        return self.phases

    @property
    def reached(self) -> bool:
        """Whether every phase verifiably reached its target."""
        return all(phase.reached for phase in self.phases)

    @property
    def status(self) -> str:
        """ "reached" or "not reached"."""
        return "reached" if self.reached else "not reached"

    @property
    def active_intervals(self) -> int:
        """Number of active intervals of all phases together."""
        return sum(phase.active_intervals for phase in self.phases)

    def __repr__(self) -> str:
        found = self.phases[0].section.brief(self.phases)
        return f"{type(self).__name__}({self.scenario.name}: {self.status}, {found})"
