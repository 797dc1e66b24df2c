"""The family of toy systems, which shows that nothing depends on a spacecraft."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.hands_off.family import SparseFamily
from jaxatt.problems.hands_off.phase_search import Build
from jaxatt.problems.hands_off.task import Flown
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.toy.build import build_toy
from jaxatt.problems.toy.file_format import FORMAT
from jaxatt.problems.toy.flight import fly_toy
from jaxatt.problems.toy.reading import read_toy
from jaxatt.problems.toy.report import TOY
from jaxatt.problems.toy.task import ToyTask
from jaxatt.runtime.arrays import Floats


class Toy(SparseFamily):
    """Family of sparse control of the double integrator and the Van der Pol oscillator."""

    name = FORMAT.name
    systems = FORMAT.systems
    tables = FORMAT.tables
    sections = TOY

    def read(
        self, document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
    ) -> Scenario:
        return read_toy(document, origin, folder, faults)

    def build(self, scenario: Scenario, start: PhaseStart) -> Build:
        return functools.partial(build_toy, initial_state=start.state)

    def fly(self, task: ToyTask, controls: Floats) -> Flown:
        return fly_toy(task, controls)
