"""JSON schemas and the page of keys: the same declaration that the loader reads."""

import copy
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft7Validator

from jaxatt import scenarios
from jaxatt.cli.schema import as_text
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.keys import TableKey
from jaxatt.problems.reading.vehicles import vehicle_names
from jaxatt.problems.registry import formats
from jaxatt.scenarios.bundled import KINDS, names
from jaxatt.scenarios.schema_line import FOLDER
from jaxatt.studies.file_kinds import OTHERS, faults_of
from jaxatt.studies.json_schema import KINDS as SCHEMAS
from jaxatt.studies.json_schema import schema_of
from jaxatt.studies.key_table import key_page

CASES = [(kind, name) for kind in KINDS if kind in SCHEMAS for name in names(kind)]
PAGE = Path(__file__).parents[2] / "docs" / "keys.md"


@pytest.fixture(scope="module")
def validators():
    return {kind: Draft7Validator(schema_of(kind)) for kind in SCHEMAS}


def places(value, path=()):
    """Paths of all keys of a document outside of what is for its reader only."""
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        if key in ("printed", "fixed", "at_most"):
            continue
        if isinstance(key, str):
            yield (*path, key)
        if isinstance(item, dict) or (
            isinstance(item, list) and item and isinstance(item[0], dict)
        ):
            yield from places(item, (*path, key))


def at(document, path):
    for part in path:
        document = document[part]
    return document


@pytest.mark.parametrize("kind", SCHEMAS)
def test_the_schemas_that_editors_find_are_up_to_date(kind):
    Draft7Validator.check_schema(schema_of(kind))
    assert (FOLDER / f"{kind}.json").read_text(encoding="utf-8") == as_text(kind)


@pytest.mark.parametrize("kind, name", CASES)
def test_bundled_files_validate_and_misspelt_ones_do_not(kind, name, validators):
    document = parse(scenarios.text(name), name)
    assert not list(validators[kind].iter_errors(document))
    rng = np.random.default_rng(len(name))
    found = [path for path in places(document) if path[:1] != ("laws",) or len(path) != 2]
    for index in rng.choice(len(found), size=min(4, len(found)), replace=False):
        wrong = copy.deepcopy(document)
        *parents, key = found[index]
        inner = at(wrong, parents)
        inner[f"{key}x"] = inner.pop(key)
        assert not validators[kind].is_valid(wrong), found[index]
        assert faults_of(wrong, name, kind), found[index]


def test_bundled_vehicles_validate(validators):
    for name in vehicle_names():
        file = resources.files("jaxatt.spacecraft") / "vehicles" / f"{name}.toml"
        document = parse(file.read_text(encoding="utf-8"), name)
        assert not list(validators["vehicle"].iter_errors(document)), name
        assert not faults_of(document, name, "vehicle"), name


def test_schema_and_loader_agree_on_ranges(validators):
    whole = parse(scenarios.text("hypso1-90-45-15"), "whole")
    for path, value, good in (
        (("orbit", "eccentricity"), -0.1, False),
        (("orbit", "inclination_deg"), 180.0, True),
        (("orbit", "inclination_deg"), 180.1, False),
        (("horizon", "intervals"), 1.5, False),
        (("horizon", "intervals"), True, False),
        (("target", "attitude_deg"), [1.0, 2.0], False),
        (("target", "attitude_mrp"), [0.0, 0.0, 0.0], False),
        (("objective", "kind"), "l2", False),
        (("solver", "seed"), 0, True),
    ):
        document = copy.deepcopy(whole)
        document[path[0]][path[1]] = value
        assert validators["manoeuvre"].is_valid(document) == good, path
        assert (not faults_of(document, "case", "manoeuvre")) == good, path


def test_every_key_has_a_meaning():
    def without(declared, path):
        for key, value in declared.items():
            if not value.meaning:
                yield f"{path}.{key}"
            if isinstance(value, TableKey):
                yield from without(value, f"{path}.{key}")

    for known in formats():
        assert not list(without(TableKey(keys_=known.tables), known.name))
    for kind, declared in OTHERS.items():
        assert not list(without(declared, kind))


def test_the_page_of_keys_is_up_to_date():
    assert PAGE.read_text(encoding="utf-8") == key_page(), "jaxatt schema --page > docs/keys.md"
