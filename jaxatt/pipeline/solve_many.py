"""Solve many scenarios of one family; one that fails spoils no other.

What is compiled for the first serves all that differ in values only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax

from jaxatt import scenarios
from jaxatt.pipeline.solve import judged, solve
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.registry import family_of
from jaxatt.report.result import Result
from jaxatt.scenarios import Scenario


@dataclass(frozen=True, eq=False)
class Attempt:
    """Answer of one scenario, or the error that its solve ended with."""

    answer: Result | None = None
    error: Exception | None = None

    @property
    def reason(self) -> str:
        """Why there is no answer that reaches the target; empty where there is one."""
        if self.answer is not None:
            missed = [phase for phase in self.answer.phases if not phase.reached]
            return "; ".join(phase.failure_reason or "not reached" for phase in missed)
        words = " ".join(str(self.error).split())
        refused = isinstance(self.error, ScenarioError)
        return words if refused else f"{type(self.error).__name__}: {words}"


def solve_many(documents: Sequence[Mapping[str, Any]], base: Scenario) -> Iterator[Attempt]:
    """Solve scenarios given by their documents, each checked like a file.

    They are searched together where their family does so (`Family.search_many`), one after the
    other otherwise.  base : the scenario that they come from, for messages and for the files that
    they name.  What the machine refuses (a full disk, no memory) is raised.
    """
    read = [_read(document, base) for document in documents]
    found = _together([case for case in read if isinstance(case, Scenario)])
    for case in read:
        if not isinstance(case, Scenario):
            yield Attempt(error=case)
            continue
        try:
            known = None if found is None else next(found)
            yield Attempt(solve(case) if found is None else judged(case, partial(_given, known)))
        except (OSError, MemoryError, jax.errors.JaxRuntimeError):
            raise
        except Exception as error:
            yield Attempt(error=error)


def _read(document: Mapping[str, Any], base: Scenario) -> Scenario | ScenarioError:
    try:
        return scenarios.from_mapping(document, origin=base.origin, folder=base.folder)
    except ScenarioError as error:
        return error


def _together(cases: Sequence[Scenario]) -> Iterator[Any] | None:
    """Searches of all cases at once, where their family does so."""
    if len(cases) < 2 or len({case.family for case in cases}) > 1:
        return None
    try:
        found = family_of(cases[0]).search_many(cases)
    except ScenarioError:  # each says by itself what is wrong with it
        return None
    return None if found is None else iter(found)


def _given(found: Any, start: object) -> Any:
    return found
