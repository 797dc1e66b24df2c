"""Answer the targets of a map chunk by chunk into a store, from where it was left."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np

from jaxatt.pipeline.solve import versions
from jaxatt.pipeline.solve_targets import CHECKED, solve_targets
from jaxatt.problems.registry import family_of
from jaxatt.report.store.layout import SAMPLE, Column, Layout
from jaxatt.report.store.store import Store
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import SAMPLES
from jaxatt.runtime.settings import check_precision
from jaxatt.scenarios import Scenario
from jaxatt.studies.attitude_map.targets import MapTargets

CHUNK = 128
"""Targets that are answered and written together."""
KIND, REACHED_COLUMN = "map", "reached"


def map_layout(scenario: Scenario, targets: MapTargets) -> Layout:
    """What the store of a map holds."""
    told = json.dumps(scenario.document, sort_keys=True, default=str)
    contents = hashlib.sha256(told.encode() + targets.q_ob.tobytes()).hexdigest()[:12]
    mapped = family_of(scenario).mapped
    return Layout(
        samples=len(targets.angle),
        chunk=CHUNK,
        identity={"map": scenario.name, "contents": contents, **versions()},
        coordinates={
            "q_ob": ((SAMPLE, "component"), targets.q_ob, {"order": "scalar first"}),
            "turn_axis": ((SAMPLE, "body_axis"), targets.axis, {"frame": "initial body axes"}),
            "turn_deg": ((SAMPLE,), np.degrees(targets.angle), {"units": "deg"}),
        },
        columns={
            **{name: Column() for name in (*mapped, *CHECKED)},
            REACHED_COLUMN: Column("bool"),
        },
        attributes={
            "kind": KIND,
            "title": f"{scenario.name}: all turns from the initial attitude",
            "scenario": scenario.name,
            "mapped": " ".join(mapped),
            "scenario_document": told,
        },
    )


def run_map(
    scenario: Scenario,
    targets: MapTargets,
    path: str | Path,
    share: tuple[int, int] = (0, 1),
    report: Report | None = None,
) -> None:
    """Answer the targets that the store at `path` does not hold yet; it is made if missing.

    share : task i of n, which has the chunks i, i + n, i + 2 n, ...  A run that ends before is
    continued by the same call, and leaves the same values.
    """
    check_precision()
    layout = map_layout(scenario, targets)
    tell = report or (lambda stage, done: None)
    with Store.open_or_create(path, layout) as store:
        done = store.done
        own = range(share[0], layout.chunks, share[1])
        tell(SAMPLES, int(sum(done[layout.rows(k)].sum() for k in own)))
        for chunk in store.pending(share):
            rows = layout.rows(chunk)
            found = solve_targets(scenario, targets.q_ob[rows])
            store.write(chunk, {**found.numbers, REACHED_COLUMN: found.reached})
            tell(SAMPLES, rows.stop - rows.start)
