"""Answer the targets of a map chunk by chunk into a store, from where it was left."""

from __future__ import annotations

from pathlib import Path

from jaxatt.pipeline.solve_targets import solve_targets
from jaxatt.report.store.store import Store
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import SAMPLES
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.attitude_map.study import REACHED_COLUMN, MapStudy


def run_map(
    study: MapStudy,
    path: str | Path,
    share: tuple[int, int] = (0, 1),
    report: Report | None = None,
) -> None:
    """Answer the targets that the store at `path` does not hold yet; it is made if missing.

    share : task i of n, which has the chunks i, i + n, i + 2 n, ...  A run that ends before is
    continued by the same call, and leaves the same values.
    """
    check_precision()
    layout = study.layout()
    tell = report or (lambda stage, done: None)
    with Store.open_or_create(path, layout) as store:
        tell(SAMPLES, store.written(share))
        for chunk in store.pending(share):
            rows = layout.rows(chunk)
            found = solve_targets(study.scenario, study.targets.q_ob[rows], tell)
            store.write(chunk, {**found.numbers, REACHED_COLUMN: found.reached})
