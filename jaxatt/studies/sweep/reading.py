"""Read a study from a TOML document."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxatt import scenarios
from jaxatt.problems.reading.documents import parse, read_file
from jaxatt.problems.reading.fields import ScenarioError, Table, shown
from jaxatt.problems.reading.heading import MOST_SEED
from jaxatt.problems.reading.names import read_name
from jaxatt.report.numbers import CLOCK
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.bundled import suggestion
from jaxatt.scenarios.loader import plain_values
from jaxatt.studies.sweep.numbers import whole_document
from jaxatt.studies.sweep.samples import METHODS, MOST, Range, grid, notes, scattered
from jaxatt.studies.sweep.study import Study
from jaxatt.studies.sweep.vary import check_apart, read_varied

_TOP = ("name", "title", "scenario", "outputs", "chunk", "fixed", "sampling", "vary")
_SAMPLING = ("method", "samples", "seed")


def is_study(name_or_path: str | Path) -> bool:
    """Whether this is a bundled study, or a TOML file that varies something."""
    kind = scenarios.kind_of(str(name_or_path))
    if kind is not None:
        return kind == "study"
    return bool({"vary", "sampling"} & set(read_study_file(name_or_path, "study", "manoeuvre")))


def load_study(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> Study:
    """Return the bundled study of this name, or the one in a TOML file.

    changes : of the scenario, as in [fixed], on top of those.  Raises `ScenarioError`.
    """
    name = str(name_or_path)
    if scenarios.kind_of(name) == "study":
        origin = f"{name}.toml"
        return read_study(parse(scenarios.text(name), origin), origin, None, changes)
    document = read_study_file(name_or_path, "study", "manoeuvre")
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
    top = Table(plain, origin, "", _TOP)
    name = read_name(top)
    scenario, fixed = read_base(top, folder, changes)
    whole = whole_document(scenario)

    sampling = Table(plain.get("sampling", {}), origin, "[sampling]", _SAMPLING)
    method = sampling.choice("method", METHODS, "grid")
    entries = top.require("vary", '"..."')
    if not isinstance(entries, list) or not entries:
        top.fail("vary", "is no list of tables", "write one [[vary]] for every swept number")
    varied = [
        read_varied(entry, k, origin, "vary", method, scenario, whole)
        for k, entry in enumerate(entries)
    ]
    check_apart(varied, origin, "vary")
    values, remarks = _samples(sampling, method, [v.range for v in varied])
    # A few hundred chunks: little is lost with a chunk, and few files are made.
    chunk = top.integer("chunk", max(1, min(256, -(-len(values) // 256))), at_most=MOST)
    study = Study(
        name=name,
        title=top.text("title", name),
        origin=origin,
        scenario=scenario,
        whole=whole,
        varied=tuple(varied),
        method=method,
        values=values,
        outputs=_outputs(top),
        chunk=min(chunk, len(values)),
        notes=remarks,
        document=json.dumps({**plain, "fixed": fixed}, sort_keys=True, default=str),
    )
    try:
        study.layout()
    except ScenarioError as error:
        raise ScenarioError(f"{origin}: {error}") from None
    return study


def _samples(table: Table, method: str, ranges: Sequence[Range]) -> tuple[Floats, tuple[str, ...]]:
    """Samples (S, D) of [sampling], and remarks on their number."""
    if method != "grid":
        count = table.integer("samples", at_most=MOST)
        seed = table.integer("seed", 0, at_least=0, at_most=MOST_SEED)
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
    value = top.require("outputs", '["active_intervals", "l1_effort_Nms"]')
    if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
        top.fail("outputs", "is no list of names", "write names of summary.json in quotes")
    for name in value:
        if value.count(name) > 1:
            top.fail("outputs", f"names {name} twice", "keep one of them")
        if name.split(".")[0] == CLOCK:
            top.fail("outputs", f"{name} is a clock's, other in every run", "drop it")
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
