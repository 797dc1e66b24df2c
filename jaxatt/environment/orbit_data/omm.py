"""Orbit Mean-Elements Messages (OMM) of the CCSDS: as XML, KVN, JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from typing import Any

from sgp4 import omm
from sgp4.api import Satrec

from jaxatt.environment import epoch
from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.orbit_data.path import OrbitDataError

_USUAL: Mapping[str, str] = {
    "CLASSIFICATION_TYPE": "U",
    "OBJECT_ID": "",
    "EPHEMERIS_TYPE": "0",
    "ELEMENT_SET_NO": "0",
    "REV_AT_EPOCH": "0",
    "MEAN_MOTION_DOT": "0",
    "MEAN_MOTION_DDOT": "0",
}
_ALLOWED: Mapping[str, tuple[str, ...]] = {
    "CENTER_NAME": ("EARTH",),
    "REF_FRAME": ("TEME",),
    "TIME_SYSTEM": ("UTC",),
    "MEAN_ELEMENT_THEORY": ("SGP4", "SGP/SGP4"),
}
"""Keys with the values for which the elements are those of SGP4."""
_LARGEST_NUMBER = 339999  # that the theory's own record can hold; it is a label only


def looks_like_omm(text: str) -> bool:
    """Whether a text is an OMM in one of its forms."""
    head = text.lstrip("\ufeff \t\r\n")
    if head.startswith(("{", "[")):
        return '"MEAN_MOTION"' in head
    if head.startswith("<"):
        return "<omm" in head.lower()
    return head.startswith("CCSDS_OMM_VERS") or "MEAN_MOTION," in head.partition("\n")[0]


def read_omm(text: str) -> list[ElementSet]:
    """Every set of a text.  Raises `OrbitDataError`."""
    try:
        rows = list(_rows(text.lstrip("\ufeff \t\r\n")))
    except (ValueError, AttributeError, TypeError, SyntaxError) as error:
        raise OrbitDataError(f"is no OMM that can be read ({error}); fetch it anew") from None
    if not rows or not all(isinstance(row, dict) for row in rows):
        raise OrbitDataError("holds no elements; fetch it anew")
    return [_element_set(row) for row in rows]


def _rows(text: str) -> Iterator[Mapping[str, Any]]:
    """The fields of each set by their names."""
    if text.startswith(("{", "[")):
        found = json.loads(text)
        yield from found if isinstance(found, list) else [found]
    elif text.startswith("<"):
        for message in _inside(ElementTree.fromstring(text), "omm"):
            leaves = (part for part in message.iter() if not len(part))
            yield {_local(leaf): (leaf.text or "").strip() for leaf in leaves}
    elif text.startswith("CCSDS_OMM_VERS"):
        pairs = (line.partition("=") for line in text.splitlines() if "=" in line)
        yield {key.strip(): value.partition("[")[0].strip() for key, _, value in pairs}
    else:
        yield from csv.DictReader(io.StringIO(text))


def _inside(root: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    return [part for part in root.iter() if _local(part) == name]


def _local(part: ElementTree.Element) -> str:
    return str(part.tag).rpartition("}")[-1]


def _element_set(row: Mapping[str, Any]) -> ElementSet:
    """The set of some fields, checked."""
    fields = {
        **_USUAL,
        **{key: str(value) for key, value in row.items() if value not in (None, "")},
    }
    for key, allowed in _ALLOWED.items():
        if fields.get(key, allowed[0]).upper() not in allowed:
            raise OrbitDataError(
                f"{key} is {fields[key]}, and only elements of SGP4 can be propagated ({key} "
                f"{' or '.join(allowed)}); give an OEM of this orbit"
            )
    name, number = fields.get("OBJECT_NAME", ""), fields.get("NORAD_CAT_ID", "")
    satrec = Satrec()
    try:
        moment = epoch.parse(fields["EPOCH"])
        # The record of the theory needs the fraction of the second, and a short number.
        fields["EPOCH"] = f"{moment:%Y-%m-%dT%H:%M:%S.%f}"
        fields["NORAD_CAT_ID"] = number if int(number) <= _LARGEST_NUMBER else "0"
        omm.initialize(satrec, fields)
    except KeyError as error:
        raise OrbitDataError(f"{error.args[0]} is missing; fetch the message anew") from None
    except (ValueError, TypeError, ArithmeticError) as error:
        raise OrbitDataError(
            f"the elements of {name or number}: {error}; fetch them anew"
        ) from None
    return ElementSet(name, number, satrec)
