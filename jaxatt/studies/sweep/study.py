"""A study: what of a scenario is varied, how it is sampled, and what is kept of every answer."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.pipeline.solve import versions
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.records.labels import Variable
from jaxatt.report.store.layout import SAMPLE, STRING, Column, Layout
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.sweep.numbers import Place, set_at, value_at
from jaxatt.studies.sweep.samples import Range

SCENARIO, STATE, REASON = "scenario", "state", "reason"
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
class Base:
    """A scenario that samples are made from, and where the varied numbers stand in it.

    whole : document of the scenario, its vehicle written out.
    """

    scenario: Scenario
    whole: Mapping[str, Any]
    varied: tuple[Varied, ...]

    def at(self, values: Sequence[float]) -> dict[str, Any]:
        """Document of the scenario with these values of the quantities."""
        document = copy.deepcopy(dict(self.whole))
        for quantity, value in zip(self.varied, values, strict=True):
            quantity.apply(document, value)
        return document


@dataclass(frozen=True, eq=False)
class Study:
    """A checked study with its samples.

    origin : what messages call its file.  bases : the scenarios, each with the same quantities.
    values : (S, D), of each quantity in each sample of one scenario; those of the first scenario
    come first.  outputs : names of `summary.json`.  against : outputs that the others are drawn
    over, too.  chunk : samples that are written together.
    """

    name: str
    title: str
    origin: str
    bases: tuple[Base, ...]
    method: str
    values: Floats
    outputs: tuple[str, ...]
    against: tuple[str, ...]
    chunk: int
    notes: tuple[str, ...]
    document: str

    @property
    def samples(self) -> int:
        """Number of samples of all scenarios."""
        return len(self.bases) * len(self.values)

    @property
    def varied(self) -> tuple[Varied, ...]:
        """The quantities, as they stand in the first scenario."""
        return self.bases[0].varied

    def base(self, index: int) -> Base:
        """What a sample is made from."""
        return self.bases[index // len(self.values)]

    def sample(self, index: int) -> dict[str, Any]:
        """Document of one sample's scenario."""
        return self.base(index).at(self.values[index % len(self.values)].tolist())

    def layout(self) -> Layout:
        """What the store of this study holds."""
        wholes = [dict(base.whole) for base in self.bases]
        whole = json.dumps(wholes, sort_keys=True, default=str)  # dates
        told = hashlib.sha256(f"{self.document}\n{whole}".encode() + self.values.tobytes())
        names = [base.scenario.name for base in self.bases]
        quantities = [quantity.name for quantity in self.varied]
        coordinates = self._coordinates(names) if len(names) > 1 else {}
        values = np.tile(self.values, (len(names), 1))
        return Layout(
            samples=self.samples,
            chunk=self.chunk,
            identity={
                "study": self.name,
                "contents": told.hexdigest()[:12],
                **versions(),
            },
            coordinates={
                **coordinates,
                **{
                    quantity.name: (
                        (SAMPLE,),
                        values[:, d],
                        {
                            "field": ", ".join(quantity.fields),
                            "change": quantity.change,
                            "spacing": quantity.range.spacing,
                        },
                    )
                    for d, quantity in enumerate(self.varied)
                },
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
                "scenarios": " ".join(names),
                "method": self.method,
                "quantities": " ".join([*coordinates, *quantities]),
                "outputs": " ".join(self.outputs),
                "against": " ".join(self.against),
                "study_document": self.document,
                "scenario_documents": whole,
            },
        )

    def _coordinates(self, names: Sequence[str]) -> dict[str, Variable]:
        """The scenario of every sample, where there are several."""
        if SCENARIO in [quantity.name for quantity in self.varied]:
            raise ScenarioError(f'name = "{SCENARIO}": tells the scenarios apart; give another one')
        return {SCENARIO: ((SAMPLE,), np.repeat(names, len(self.values)), {})}


def _changed(change: str, before: Any, value: float) -> float:
    if change == "multiply":
        return float(before * value)
    return float(before + value) if change == "add" else value
