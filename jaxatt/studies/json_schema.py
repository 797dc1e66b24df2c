"""JSON schemas of all kinds of TOML files, made from what is declared of their keys.

In draft 7, which editors of TOML (Taplo, Even Better TOML) read.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.keys import Either, Key, Schema, TableKey
from jaxatt.problems.reading.schema import SPACECRAFT, scenario_keys, unit_of
from jaxatt.problems.registry import FORMATS
from jaxatt.studies.file_kinds import OTHERS

KINDS = ("manoeuvre", *OTHERS)
"""Kinds of files that have a schema."""

_KEYWORDS = ("properties", "additionalProperties", "items", "allOf", "anyOf", "oneOf")
_DRAFT = "http://json-schema.org/draft-07/schema#"


def schema_of(kind: str) -> Schema:
    """The schema of one of `KINDS`."""
    found = _scenario() if kind == "manoeuvre" else _table(OTHERS[kind])
    definitions: Schema = {}
    shared = {name: _shared(value, name, definitions) for name, value in found.items()}
    top = {"$schema": _DRAFT, "title": f"jaxatt {kind}", **shared}
    return {**top, "definitions": definitions} if definitions else top


def _shared(found: Any, name: str, definitions: Schema) -> Any:
    """A part of a schema whose tables are written once, among the definitions."""
    if isinstance(found, list):
        return [_shared(item, name, definitions) for item in found]
    if not isinstance(found, dict):
        return found
    inner = {
        key: _shared(value, name if key in _KEYWORDS else key, definitions)
        for key, value in found.items()
    }
    if inner.get("type") != "object":
        return inner
    told = {"description": inner.pop("description")} if "description" in inner else {}
    number = 1
    while definitions.setdefault(f"{name}-{number}", inner) != inner:
        number += 1
    return {**told, "allOf": [{"$ref": f"#/definitions/{name}-{number}"}]}


def _scenario() -> Schema:
    """Scenarios, whose tables depend on the system and the kind of objective."""
    default, *others = FORMATS
    found: Schema = _table(_keys(default))
    for each in others:
        found = {"if": _condition(each), "then": _table(_keys(each)), "else": found}
    return found


def _keys(known: FileFormat) -> TableKey:
    return scenario_keys(known.tables, known.systems)


def _condition(known: FileFormat) -> Schema:
    """Schema of what makes a document one of a family that is not the default."""
    if SPACECRAFT not in known.systems:
        return {"properties": {"system": {"enum": list(known.systems)}}, "required": ["system"]}
    kind = {"properties": {"kind": {"enum": list(known.kinds)}}, "required": ["kind"]}
    return {"properties": {"objective": kind}, "required": ["objective"]}


def _table(declared: TableKey) -> Schema:
    """One table."""
    if declared.variants:
        kinds = [_table(declared.of({"kind": kind})) for kind in declared.variants]
        for kind, name in zip(kinds, declared.variants, strict=True):
            kind["properties"]["kind"] = {**kind["properties"]["kind"], "enum": [name]}
        return {"oneOf": kinds}
    conditions: list[Schema] = [
        {"anyOf": [{"required": [name]} for name in (key, *value.unless)]}
        for key, value in declared.items()
        if value.required and value.unless
    ]
    conditions += [
        {"not": {"required": list(pair)}}
        for group in declared.apart
        for pair in combinations(group, 2)
    ]
    required = [k for k, value in declared.items() if value.required and not value.unless]
    return {
        "type": "object",
        "properties": {key: _described(key, value) for key, value in declared.items()},
        "additionalProperties": False if declared.free is None else _value(declared.free),
        **({"required": required} if required else {}),
        **({"allOf": conditions} if conditions else {}),
    }


def _described(key: str, declared: Key) -> Schema:
    """Schema of a value with its meaning, unit and default, for those who hover over it."""
    unit = unit_of(key)
    told = f"{declared.meaning} [{unit}]" if unit else declared.meaning
    if declared.otherwise:
        told = f"{told}; by default {declared.otherwise}"
    default = {} if declared.default is None else {"default": declared.default}
    return {**_value(declared), "description": told, **default}


def _value(declared: Key) -> Schema:
    """Schema of a value."""
    if isinstance(declared, TableKey):
        one = _table(declared)
        return {"type": "array", "items": one} if declared.many else one
    if isinstance(declared, Either):
        return {"anyOf": [_value(form) for form in declared.forms]}
    return declared.schema()
