"""Run a study: solve its samples chunk by chunk into a store, from where it was left."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jaxatt.pipeline.solve_many import Attempt, solve_many
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.store.store import Store
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import SAMPLES
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.sweep.outputs import check_outputs, number_at
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, REASON, STATE, Study

_TRIED = 8
"""Samples that are tried for one that has an answer, before anything is written."""


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
    known: dict[int, Attempt] = {}
    chunks = range(share[0], layout.chunks, share[1])
    if chunks and not Path(path).exists():
        known = _first_answers(study, layout.rows(chunks[0]).start)
    with Store.open_or_create(path, layout) as store:
        if report is not None:
            report(SAMPLES, int(sum(store.done[layout.rows(k)].sum() for k in chunks)))
        for chunk in store.pending(share):
            rows = layout.rows(chunk)
            attempts = []
            for index in range(rows.start, rows.stop):
                attempts.append(known.get(index) or _solve(study, index))
                if report is not None:
                    report(SAMPLES, 1)
            store.write(chunk, _columns(study, attempts))


def samples_of(study: Study, share: tuple[int, int]) -> int:
    """Number of samples of task i of n."""
    layout = study.layout()
    chunks = (layout.rows(k) for k in range(share[0], layout.chunks, share[1]))
    return sum(rows.stop - rows.start for rows in chunks)


def _solve(study: Study, index: int) -> Attempt:
    return next(solve_many([study.sample(index)], study.scenario))


def _first_answers(study: Study, first: int) -> dict[int, Attempt]:
    """Solve samples until one has an answer, and check the names of the outputs with it."""
    known: dict[int, Attempt] = {}
    count = len(study.values)
    for k in range(min(_TRIED, count)):
        index = (first + k * count // min(_TRIED, count)) % count
        attempt = known[index] = _solve(study, index)
        if attempt.answer is not None:
            check_outputs(attempt.answer.summary(), study.outputs, study.origin)
            return known
    errors = [attempt.error for attempt in known.values()]
    refused = [error for error in errors if isinstance(error, ScenarioError)]
    if not refused:
        assert errors[0] is not None
        raise errors[0]
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
