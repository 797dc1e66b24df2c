"""Read a study from a TOML document."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from jaxatt import scenarios
from jaxatt.problems.reading.checking import refuse_faults
from jaxatt.problems.reading.documents import parse, read_file
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table, shown
from jaxatt.problems.reading.names import read_name
from jaxatt.report.numbers import CLOCK
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.bundled import suggestion
from jaxatt.scenarios.loader import plain_values
from jaxatt.studies.sweep.numbers import whole_document
from jaxatt.studies.sweep.samples import Range, grid, notes, scattered
from jaxatt.studies.sweep.study import Base, Study
from jaxatt.studies.sweep.vary import check_apart, read_varied
from jaxatt.studies.tables import MOST_SAMPLES, SAMPLING, STUDY_KEYS


def load_study(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> Study:
    """Return the bundled study of this name, or the one in a TOML file.

    changes : of the scenario, as in [fixed], on top of those.  Raises `ScenarioError`.
    """
    name = str(name_or_path)
    kind = scenarios.kind_of(name)
    if kind == "study":
        origin = f"{name}.toml"
        return read_study(parse(scenarios.text(name), origin), origin, None, changes)
    document = {} if kind is not None else read_study_file(name_or_path, "study")
    if not {"vary", "sampling", "outputs"} & set(document):
        raise ScenarioError(
            f"{name}: varies nothing; write a study with scenario = "
            f"{json.dumps(name)}, outputs and [[vary]], such as the one of "
            "'jaxatt scenarios show time-and-effort'"
        )
    return read_study(document, name, Path(name_or_path).parent, changes)


def read_study_file(name_or_path: str | Path, *kinds: str) -> dict[str, Any]:
    """Document of a study's file; where there is none, near names of these kinds are suggested."""
    path = Path(name_or_path)
    if path.suffix != ".toml" and not os.path.isfile(path):
        hint = suggestion(str(name_or_path), *kinds)
        raise ScenarioError(f"{name_or_path}: neither a bundled study nor a file; {hint}")
    return read_file(path)


def read_study(
    document: Mapping[str, Any],
    origin: str = "study",
    folder: Path | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Study:
    """Check a document that has the names of a study's file, and draw its samples.

    folder : where the scenario's file is looked up; the working folder by default.
    """
    plain = plain_values(document)
    refuse_faults(plain, origin, STUDY_KEYS)
    top = Table(plain, origin, "", STUDY_KEYS)
    name = read_name(top)
    bases, fixed = _bases(plain, top, folder, changes)

    sampling = Table(plain.get("sampling", {}), origin, "[sampling]", SAMPLING)
    method = sampling.choice("method")
    entries = top.require("vary")
    if not isinstance(entries, list) or not entries:
        top.fail("vary", "is no list of tables", "write one [[vary]] for every swept number")
    bases = tuple(_varying(base, entries, method, origin) for base in bases)
    values, remarks = _samples(sampling, method, [v.range for v in bases[0].varied])
    count = len(bases) * len(values)
    if count > MOST_SAMPLES:
        raise ScenarioError(
            f"{origin}: scenario: {len(bases)} scenarios make {count} samples; at most "
            f"{MOST_SAMPLES} are made"
        )
    # A few hundred chunks: little is lost with a chunk, and few files are made.
    chunk = top.integer("chunk", max(1, min(256, -(-count // 256))))
    outputs = _outputs(top)
    study = Study(
        name=name,
        title=top.text("title", name),
        origin=origin,
        bases=bases,
        method=method,
        values=values,
        outputs=outputs,
        against=_against(top, outputs),
        chunk=min(chunk, count),
        notes=remarks,
        document=json.dumps({**plain, "fixed": fixed}, sort_keys=True, default=str),
    )
    try:
        study.layout()
    except ScenarioError as error:
        raise ScenarioError(f"{origin}: {error}") from None
    return study


def _bases(
    plain: Mapping[str, Any], top: Table, folder: Path | None, changes: Mapping[str, Any] | None
) -> tuple[tuple[Base, ...], dict[str, Any]]:
    """The scenarios of a study before anything is varied, and what [fixed] changes in all."""
    given = plain.get("scenario")
    fixed: dict[str, Any] = {}
    if not isinstance(given, list):
        scenario, fixed = read_base(top, folder, changes)
        return (Base(scenario, whole_document(scenario), ()),), fixed
    if not given or not all(isinstance(name, str) for name in given):
        top.fail("scenario", "is no list of names", "write names of scenarios in quotes")
    bases: list[Base] = []
    for name in given:
        one = Table({**plain, "scenario": name}, top.origin, "", STUDY_KEYS)
        scenario, fixed = read_base(one, folder, changes)
        if scenario.name in [base.scenario.name for base in bases]:
            top.fail("scenario", f"names {scenario.name} twice", "keep one of them")
        bases.append(Base(scenario, whole_document(scenario), ()))
    return tuple(bases), fixed


def _varying(base: Base, entries: Sequence[Any], method: str, origin: str) -> Base:
    """A scenario with the quantities that are varied in it."""
    faults = Faults()
    varied = [
        faults.of(read_varied, entry, k, origin, "vary", method, base.scenario, base.whole)
        for k, entry in enumerate(entries)
    ]
    faults.refuse()
    check_apart(varied, origin, "vary")
    return replace(base, varied=tuple(varied))


def _samples(table: Table, method: str, ranges: Sequence[Range]) -> tuple[Floats, tuple[str, ...]]:
    """Samples (S, D) of [sampling], and remarks on their number."""
    if method != "grid":
        count = table.integer("samples")
        seed = table.integer("seed")
        return scattered(method, ranges, count, seed), notes(method, count)
    for key in ("samples", "seed"):
        if key in table:
            table.fail(key, "a grid has all combinations of its values", "drop it")
    try:
        return grid(ranges), ()
    except ScenarioError as error:
        raise ScenarioError(f"{table.origin}: {error}") from None


def read_base(
    top: Table, folder: Path | None, changes: Mapping[str, Any] | None
) -> tuple[scenarios.Scenario, dict[str, Any]]:
    """The scenario that a study begins with, changed by [fixed], and these changes."""
    fixed = {**dict(_flat(top.data.get("fixed", {}), "", top.origin)), **(changes or {})}
    scenario = _scenario(top.text("scenario", " ").strip(), top, folder)
    return (scenarios.replace(scenario, fixed) if fixed else scenario), fixed


def _scenario(name: str, top: Table, folder: Path | None) -> scenarios.Scenario:
    if not name:
        top.fail("scenario", "missing", 'add a line such as scenario = "hypso1-90-45-15"')
    if name in scenarios.names() or folder is None:
        return scenarios.load(name)
    return scenarios.load(folder / name if name.endswith(".toml") else name)


def _outputs(top: Table) -> tuple[str, ...]:
    value = top.require("outputs")
    if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
        top.fail("outputs", "is no list of names", "write names of summary.json in quotes")
    for name in value:
        if value.count(name) > 1:
            top.fail("outputs", f"names {name} twice", "keep one of them")
        if name.split(".")[0] == CLOCK:
            top.fail("outputs", f"{name} is a clock's, other in every run", "drop it")
    return tuple(value)


def _against(top: Table, outputs: Sequence[str]) -> tuple[str, ...]:
    value = top.data.get("against", [])
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        top.fail("against", "is no list of names", 'write names of outputs, as ["final_time_s"]')
    for name in value:
        if name not in outputs or value.count(name) > 1:
            top.fail("against", f"{name} is no output, or stands twice", "name outputs once each")
    return tuple(value)


def _flat(value: Any, before: str, origin: str) -> Iterator[tuple[str, Any]]:
    """Entries of nested tables by their dotted names."""
    if not isinstance(value, dict):
        raise ScenarioError(
            f"{origin}: [fixed] = {shown(value)}: is no table; write solver.starts = 8"
        )
    for key, item in value.items():
        name = f"{before}.{key}" if before else key
        if isinstance(item, dict):
            yield from _flat(item, name, origin)
        else:
            yield name, item
