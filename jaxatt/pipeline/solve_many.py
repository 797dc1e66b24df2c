"""Solve many scenarios of one family one after the other; one that fails spoils no other.

What is compiled for the first serves all that differ in values only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.result import Result


@dataclass(frozen=True, eq=False)
class Attempt:
    """Answer of one scenario, or the error that its solve ended with."""

    answer: Result | None = None
    error: Exception | None = None

    @property
    def reason(self) -> str:
        """Why there is no answer that reaches the target; empty where there is one."""
        if self.answer is not None:
            phases = [p for p in self.answer.phases if not p.reached]
            return "; ".join(phase.failure_reason or "not reached" for phase in phases)
        words = " ".join(str(self.error).split())
        return (
            words
            if isinstance(self.error, ScenarioError)
            else f"{type(self.error).__name__}: {words}"
        )


def solve_many(
    documents: Iterable[Mapping[str, Any]], base: scenarios.Scenario
) -> Iterator[Attempt]:
    """Solve scenarios given by their documents, each checked like a file.

    base : the scenario that they come from, for messages and for the files that they name.
    What the system refuses (a full disk, no memory) is raised.
    """
    for document in documents:
        try:
            scenario = scenarios.from_mapping(document, origin=base.origin, folder=base.folder)
            yield Attempt(answer=solve(scenario))
        except (OSError, MemoryError):
            raise
        except Exception as error:
            yield Attempt(error=error)
