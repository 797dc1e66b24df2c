"""Documents with one odd value: any key of a bundled file, any wrong type or size."""

import copy
import datetime
import functools
import math
from importlib import resources

from hypothesis import strategies as st

from jaxatt import scenarios
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.vehicle import VEHICLE_PARTS
from jaxatt.problems.toy.tables import TOY_TABLES
from jaxatt.scenarios.flight_schema import DRAG_KEYS, FLIGHT_TABLES, SOLAR_KEYS

GONE, DOUBLED = "gone", "doubled"
"""Edits that are no values: the key is removed; a number, list or text is there twice."""

ODD = (
    *(True, "", "x", "\0", "a\0b", "a/b", "x" * 300, "é"),
    *([], [[]], [1], ["x"], [{}], {}, {"x": 1}, [True] * 3, [[1, 2], [3]]),
    *(0, -0.0, -1, 1, 2, 3, 2**31 - 1, 2**31, 2**63, 2**64, 10**30, 10**400, -(10**400)),
    *(5e-324, 1e-300, 1e300, 1e308, -1e308, math.nan, math.inf, -math.inf),
    *([0, 0, 0], [0.0] * 4, [1e308] * 3, [1e200] * 4, [5e-324] * 3, [math.nan] * 3),
    *([10**400] * 3, [[10**400] * 3] * 3, [[1e308] * 3] * 3, [[0.0] * 3] * 3),
    *(datetime.datetime(2020, 1, 1), datetime.date(2020, 1, 1), datetime.time(1, 2)),
)
"""Values of every type that TOML has, of wrong sizes and of extreme ones."""

_INNER = {
    **{("vehicle", part): keys for part, keys in VEHICLE_PARTS.items()},
    ("environment", "drag"): DRAG_KEYS,
    ("environment", "solar_pressure"): SOLAR_KEYS,
}


def document(name):
    """The document of a bundled manoeuvre or flight, with its vehicle written out."""
    whole = parse(scenarios.text(name), name)
    given = whole.get("vehicle", {})
    if "use" in given:
        file = resources.files("jaxatt.spacecraft") / "vehicles" / f"{given.pop('use')}.toml"
        base = parse(file.read_text(encoding="utf-8"), name)
        parts = {k: {**base.get(k, {}), **v} for k, v in given.items() if isinstance(v, dict)}
        whole["vehicle"] = {**base, **given, **parts}
    return whole


def places(whole, tables):
    """Paths of all values of a document, and of all keys that its tables could hold besides."""
    found = list(_within(whole, ()))
    allowed = {(), *((name,) for name in tables), *_INNER}
    for path in allowed:
        table = _at(whole, path)
        table = table[0] if isinstance(table, list) and table else table
        if isinstance(table, dict):
            path = path if isinstance(_at(whole, path), dict) else (*path, 0)
            known = tuple(tables) if not path else tables.get(path[0], ())
            found += [(*path, key) for key in _INNER.get(path, known) if key not in table]
    return found


def _within(value, path):
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else ()
    for key, item in enumerate(value[:2]) if isinstance(value, list) else items:
        yield from _within(item, (*path, key))


def _at(whole, path):
    for key in path:
        whole = whole.get(key) if isinstance(whole, dict) else None
    return whole


def edited(whole, path, value):
    """A copy with one value replaced, removed or doubled."""
    whole = copy.deepcopy(whole)
    *parents, key = path
    place = whole
    for part in parents:
        place = place[part]
    if value == GONE:
        if isinstance(place, list) or key in place:
            del place[key]
    elif value == DOUBLED:
        old = place[key] if isinstance(place, list) else place.get(key, [])
        place[key] = {**old} if isinstance(old, dict) else old + old if _joins(old) else [old, old]
    else:
        place[key] = copy.deepcopy(value)
    return whole


def _joins(value):
    return isinstance(value, (int, float, str, list)) and not isinstance(value, bool)


_TABLES = {
    "toy": TOY_TABLES,
    "net-power": NET_POWER_TABLES,
}


@functools.cache
def _case(name):
    whole = document(name)
    if name in scenarios.names("flight"):
        return whole, places(whole, FLIGHT_TABLES)
    family = scenarios.load(name).family
    return whole, places(whole, _TABLES.get(family, SPACECRAFT_TABLES))


@st.composite
def odd_documents(draw, names):
    """Name of a bundled file, path and odd value, and the document with it."""
    name = draw(st.sampled_from(names))
    whole, paths = _case(name)
    path = draw(st.sampled_from(paths))
    value = draw(st.sampled_from((*ODD, GONE, DOUBLED)))
    return name, path, value, edited(whole, path, value)
