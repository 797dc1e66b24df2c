"""A checked map: its scenario, its targets, and what its store holds."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt import scenarios
from jaxatt.pipeline.solve import versions
from jaxatt.pipeline.solve_targets import CHECKED
from jaxatt.problems.registry import family_of
from jaxatt.report.store.layout import SAMPLE, Column, Layout
from jaxatt.studies.attitude_map.targets import MapTargets, map_targets

CHUNK = 128
"""Targets that are answered and written together."""
STARTS = 8
"""Starts of a target, unless others are asked for or the scenario has fewer."""
KIND, REACHED_COLUMN = "map", "reached"


@dataclass(frozen=True, eq=False)
class MapStudy:
    """A scenario whose target the targets of a map take the place of."""

    scenario: scenarios.Scenario
    targets: MapTargets

    @property
    def name(self) -> str:
        """Name of the store."""
        return f"{self.scenario.name}-map"

    def layout(self) -> Layout:
        """What the store of this map holds."""
        scenario, targets = self.scenario, self.targets
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


def map_study(
    scenario: scenarios.Scenario | str | Path,
    targets: int,
    objective: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
) -> MapStudy:
    """Check a map, with `STARTS` starts a target unless told otherwise; see `attitude_map`."""
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    changes: dict[str, Any] = {
        "objective.kind": objective,
        "solver.starts": starts or min(STARTS, scenario.solver.starts),
        "solver.seed": seed,
    }
    scenario = scenarios.replace(scenario, {k: v for k, v in changes.items() if v is not None})
    return MapStudy(scenario, map_targets(scenario, targets))
