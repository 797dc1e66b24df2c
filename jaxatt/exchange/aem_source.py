"""Take an Attitude Ephemeris Message apart, in keywords and values (KVN) or in XML."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from jaxatt.exchange.motion import FileFormatError

QUATERNION = ("Q1", "Q2", "Q3", "QC")
_DERIVATIVE = tuple(f"{name}_DOT" for name in QUATERNION)
_ANGULAR_VELOCITY = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
_COLUMNS = {
    "QUATERNION": QUATERNION,
    "QUATERNION/DERIVATIVE": (*QUATERNION, *_DERIVATIVE),
    "QUATERNION/ANGVEL": (*QUATERNION, *_ANGULAR_VELOCITY),
}
"""Columns of a line of data behind its epoch, where the scalar comes last."""
_LARGEST = 2**30


@dataclass(frozen=True)
class Block:
    """One span of a message: its keywords, and its rows as texts by the names of their columns.

    version : the major number of the message's.  where : file and line, for errors.
    """

    version: int
    where: str
    keywords: Mapping[str, str]
    rows: list[tuple[str, Mapping[str, str]]] = field(default_factory=list)


def blocks(path: Path) -> list[Block]:
    """Blocks of a file; raises `FileFormatError` where it is no AEM of quaternions."""
    try:
        if path.stat().st_size > _LARGEST:
            raise FileFormatError(str(path), "is larger than 1 GiB", "split it in time")
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeError:
        mend = "give an AEM as a text file, KVN or XML"
        raise FileFormatError(str(path), "is no text in UTF-8", mend) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileFormatError(str(path), f"cannot be read ({reason})", "check the path") from None
    found = _of_xml(text, path) if text.lstrip().startswith("<") else list(_of_kvn(text, path))
    if not any(block.rows for block in found):
        raise FileFormatError(str(path), "holds no attitudes", "check that it is complete")
    return found


def _of_kvn(text: str, path: Path) -> Iterator[Block]:
    version, block, within = 0, None, ""
    keywords: dict[str, str] = {}
    for number, raw in enumerate(text.splitlines(), start=1):
        line, where = raw.strip(), f"{path}, line {number}"
        if not line or line.startswith("COMMENT"):
            continue
        key, equals, value = (part.strip() for part in line.partition("="))
        if not version:
            version = _version(key, value, where)
        elif line == "META_START":
            keywords, within = {}, "keywords"
        elif line == "META_STOP":
            block, within = Block(version, where, keywords), ""
        elif line == "DATA_START" and block is not None:
            within, names = "rows", _names(block)
        elif line == "DATA_STOP" and block is not None:
            within = ""
            yield block
        elif equals and within == "keywords":
            keywords[key] = value
        elif within == "rows" and block is not None:
            stamp, *numbers = line.split()
            if len(numbers) != len(names):
                raise FileFormatError(
                    where,
                    f"has {len(numbers)} numbers behind its epoch",
                    f"complete it: {block.keywords['ATTITUDE_TYPE']} has {len(names)}, "
                    f"{', '.join(names)}",
                )
            block.rows.append((stamp, dict(zip(names, numbers, strict=True))))
        elif not equals:
            mend = "expected a keyword with its value, or META_START or DATA_START before it"
            raise FileFormatError(where, f"has no place in an AEM: {line[:60]}", mend)
    if within:
        mend = "it seems to be cut off"
        raise FileFormatError(str(path), "ends within a block of " + within, mend)


def _names(block: Block) -> tuple[str, ...]:
    kind = block.keywords.get("ATTITUDE_TYPE", "").upper()
    names = _known_columns(kind, block.where)
    if _scalar_first(block):
        names = tuple(names[i] for i in (3, 0, 1, 2)) + (
            tuple(names[i] for i in (7, 4, 5, 6)) if names[4:] == _DERIVATIVE else names[4:]
        )
    return names


def _known_columns(kind: str, where: str) -> tuple[str, ...]:
    if kind not in _COLUMNS:
        known = ", ".join(_COLUMNS)
        raise FileFormatError(
            where,
            f"ATTITUDE_TYPE = {kind or 'nothing'}: only quaternions are read",
            f"have the file written with one of {known}",
        )
    return _COLUMNS[kind]


def _scalar_first(block: Block) -> bool:
    """Whether the rows of a KVN block begin with the scalar."""
    place = block.keywords.get("QUATERNION_TYPE", "").upper()
    if block.version == 1 and place not in ("FIRST", "LAST"):
        raise FileFormatError(
            block.where,
            "QUATERNION_TYPE is missing, which says where the scalar stands",
            "add QUATERNION_TYPE = LAST or FIRST, as its writer had it",
        )
    if block.version != 1 and place == "FIRST":
        raise FileFormatError(
            block.where,
            f"QUATERNION_TYPE = FIRST in version {block.version}, whose scalar is the last number",
            "put the scalar last and drop the keyword, or write version 1.0",
        )
    return place == "FIRST"


def _version(key: str, value: str, where: str) -> int:
    if key != "CCSDS_AEM_VERS":
        raise FileFormatError(
            where, "an AEM begins with CCSDS_AEM_VERS", "give a CCSDS attitude ephemeris message"
        )
    major = value.split(".")[0]
    if major not in ("1", "2"):
        raise FileFormatError(where, f"CCSDS_AEM_VERS = {value}", "versions 1 and 2 are read")
    return int(major)


def _of_xml(text: str, path: Path) -> list[Block]:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise FileFormatError(str(path), "declares entities of its own", "leave them out")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise FileFormatError(str(path), f"is no valid XML ({error})", "check it") from None
    messages = [element for element in root.iter() if _tag(element) == "aem"]
    if len(messages) != 1:
        mend = "give a file with one CCSDS attitude ephemeris message"
        raise FileFormatError(str(path), f"holds {len(messages)} elements <aem>", mend)
    version = _version(messages[0].get("id", ""), messages[0].get("version", ""), str(path))
    found = []
    for number, segment in enumerate(e for e in messages[0].iter() if _tag(e) == "segment"):
        where = f"{path}, segment {number + 1}"
        parts = {_tag(part): part for part in segment}
        if "metadata" not in parts or "data" not in parts:
            raise FileFormatError(where, "lacks metadata or data", "check that it is complete")
        block = Block(version, where, dict(_leaves(parts["metadata"])))
        names = _known_columns(block.keywords.get("ATTITUDE_TYPE", "").upper(), where)
        for state in (e for e in parts["data"] if _tag(e) == "attitudeState"):
            row = dict(_leaves(state))
            missing = [name for name in ("EPOCH", *names) if name not in row]
            if missing:
                mend = "check that it is complete"
                raise FileFormatError(where, f"a state lacks {', '.join(missing)}", mend)
            block.rows.append((row["EPOCH"], row))
        found.append(block)
    return found


def _leaves(element: ElementTree.Element) -> Iterator[tuple[str, str]]:
    for part in element.iter():
        if not len(part) and part.text is not None:
            yield _tag(part), part.text.strip()


def _tag(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition("}")[2]
