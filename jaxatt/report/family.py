"""Look up the sections that a family adds to a report."""

from __future__ import annotations

from jaxatt.problems.answer import Answer
from jaxatt.problems.registry import family_named
from jaxatt.problems.sections import Sections
from jaxatt.records.phase import Phase


def sections_of(answer: Answer) -> Sections:
    """Sections that the family of an answer adds to its report."""
    return sections_of_phase(answer.phases[0])


def sections_of_phase(phase: Phase) -> Sections:
    """Sections that the family of a phase adds to a report."""
    return family_named(phase.family).sections
