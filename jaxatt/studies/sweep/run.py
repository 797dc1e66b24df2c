"""Run a study: solve its samples chunk by chunk into a store, from where it was left."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from jaxatt.pipeline.solve_many import Attempt, solve_many
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.numbers import check_outputs, number_at
from jaxatt.report.store.layout import Layout
from jaxatt.report.store.store import Store
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import SAMPLES
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, REASON, STATE, Study

_TRIED = 8
"""Chunks that are tried for one that has an answer, before anything is written."""


def run_study(
    study: Study,
    path: str | Path,
    share: tuple[int, int] = (0, 1),
    report: Report | None = None,
) -> None:
    """Solve what is missing of a study's samples in the store at `path`, which is made if missing.

    share : task i of n, which has the chunks i, i + n, i + 2 n, ...  A chunk is written once all of
    its samples are solved; a run that ends before is continued by the same call, and leaves the
    same values.  A sample that fails keeps its reason, and the others go on.

    Raises `ScenarioError` where no sample has an answer or an output is unknown, and `OutputError`
    where the store is of another study or cannot be written.
    """
    check_precision()
    layout = study.layout()
    chunks = layout.chunks_of(share)
    known = {} if Path(path).exists() else _first_answers(study, layout, chunks)
    with Store.open_or_create(path, layout) as store:
        tell = report or (lambda stage, done: None)
        tell(SAMPLES, store.written(share))
        for chunk in store.pending(share):
            attempts = known.pop(chunk, [])
            tell(SAMPLES, len(attempts))
            if not attempts:
                for attempt in _attempts(study, layout.rows(chunk)):
                    attempts.append(attempt)
                    tell(SAMPLES, 1)
            store.write(chunk, _columns(study, attempts))


def _attempts(study: Study, rows: slice) -> Iterator[Attempt]:
    """Solve the samples of a chunk, those of each scenario together."""
    for base, indices in itertools.groupby(range(rows.start, rows.stop), study.base):
        yield from solve_many([study.sample(index) for index in indices], base.scenario)


def _first_answers(study: Study, layout: Layout, chunks: Sequence[int]) -> dict[int, list[Attempt]]:
    """Solve chunks until a sample has an answer, and check the names of the outputs with it."""
    known: dict[int, list[Attempt]] = {}
    checked = False
    for k in chunks[:: -(-len(chunks) // _TRIED) or 1]:
        known[k] = []
        for attempt in _attempts(study, layout.rows(k)):
            known[k].append(attempt)
            if attempt.answer is not None and not checked:
                checked = True
                check_outputs(attempt.answer.summary(), study.outputs, study.origin)
        if checked:
            return known
    if not known:
        return known
    errors = [attempt.error for attempts in known.values() for attempt in attempts]
    refused = [error for error in errors if isinstance(error, ScenarioError)]
    if not refused:
        return known
    raise ScenarioError(
        f"{study.origin}: none of {len(errors)} samples tried makes a scenario that can be solved; "
        f"the first: {refused[0]}"
    )


def _columns(study: Study, attempts: Sequence[Attempt]) -> dict[str, Any]:
    """Columns of a chunk."""
    columns: dict[str, Any] = {name: [] for name in (*study.outputs, STATE, REASON)}
    for attempt in attempts:
        answer = attempt.answer
        summary = {} if answer is None else answer.summary()
        for name in study.outputs:
            columns[name].append(number_at(summary, name))
        reached = REACHED if answer is not None and answer.reached else NOT_REACHED
        columns[STATE].append(FAILED if answer is None else reached)
        columns[REASON].append(attempt.reason)
    return columns
