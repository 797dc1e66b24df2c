"""A study: what of a scenario is varied, how it is sampled, and what is kept of every answer."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from jaxatt.pipeline.solve import versions
from jaxatt.problems.scenario import Scenario
from jaxatt.report.store.layout import SAMPLE, STRING, Column, Layout
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.sweep.numbers import Place, set_at, value_at
from jaxatt.studies.sweep.samples import Range

CHANGES = ("set", "multiply", "add")

STATE, REASON = "state", "reason"
REACHED, NOT_REACHED, FAILED = 1, 2, 3
_MEANINGS = "not_computed reached not_reached failed"


@dataclass(frozen=True, eq=False)
class Varied:
    """One swept quantity: its name, the numbers of the scenario that follow it, and its values.

    fields : names of the numbers as written.  places : where they are.  change : one of `CHANGES`.
    """

    name: str
    fields: tuple[str, ...]
    places: tuple[Place, ...]
    change: str
    range: Range

    def apply(self, document: dict[str, Any], value: float) -> None:
        """Change a document's numbers by a value of the quantity."""
        for place in self.places:
            before = value_at(document, place)
            number = _changed(self.change, before, value)
            count = self.range.whole or isinstance(before, int)
            exact = count and number.is_integer()
            set_at(document, place, int(number) if exact else number)


@dataclass(frozen=True, eq=False)
class Study:
    """A checked study with its samples.

    origin : what messages call its file.  whole : document of the scenario, its vehicle written
    out.  values : (S, D), of each quantity in each sample.  outputs : names of `summary.json`.
    chunk : samples that are written together.
    """

    name: str
    title: str
    origin: str
    scenario: Scenario
    whole: Mapping[str, Any]
    varied: tuple[Varied, ...]
    method: str
    values: Floats
    outputs: tuple[str, ...]
    chunk: int
    notes: tuple[str, ...]
    document: str

    def sample(self, index: int) -> dict[str, Any]:
        """Document of one sample's scenario."""
        document = copy.deepcopy(dict(self.whole))
        for quantity, value in zip(self.varied, self.values[index].tolist(), strict=True):
            quantity.apply(document, value)
        return document

    def layout(self) -> Layout:
        """What the store of this study holds."""
        whole = json.dumps(self.whole, sort_keys=True, default=str)  # dates
        told = hashlib.sha256(f"{self.document}\n{whole}".encode() + self.values.tobytes())
        return Layout(
            samples=len(self.values),
            chunk=self.chunk,
            identity={
                "study": self.name,
                "contents": told.hexdigest()[:12],
                **versions(),
            },
            coordinates={
                quantity.name: (
                    (SAMPLE,),
                    self.values[:, d],
                    {
                        "field": ", ".join(quantity.fields),
                        "change": quantity.change,
                        "spacing": quantity.range.spacing,
                    },
                )
                for d, quantity in enumerate(self.varied)
            },
            columns={
                **{name: Column() for name in self.outputs},
                STATE: Column(
                    "int8", attributes={"flag_values": "0 1 2 3", "flag_meanings": _MEANINGS}
                ),
                REASON: Column(STRING),
            },
            attributes={
                "kind": "sweep",
                "title": self.title,
                "scenario": self.scenario.name,
                "method": self.method,
                "quantities": " ".join(quantity.name for quantity in self.varied),
                "outputs": " ".join(self.outputs),
                "study_document": self.document,
                "scenario_document": whole,
            },
        )


def _changed(change: str, before: Any, value: float) -> float:
    if change == "multiply":
        return float(before * value)
    return float(before + value) if change == "add" else value
