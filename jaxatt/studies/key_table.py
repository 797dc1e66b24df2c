"""The page of all keys of TOML files, made from what is declared of them."""

from __future__ import annotations

from collections.abc import Iterator

from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.keys import Key, TableKey
from jaxatt.problems.reading.schema import SPACECRAFT, UNITS, scenario_keys
from jaxatt.problems.registry import FORMATS
from jaxatt.studies.file_kinds import OTHERS

_HEAD = """# Keys of all files

Made by `jaxatt schema --page` from what the loader checks; a test says when it is out of date.
**Bold** keys must be there. How files are written and checked: [files](files.md).
"""
_TITLES = {
    "flight": "Flights of feedback laws",
    "study": "Sweeps",
    "design": "Designs",
    "vehicle": "Vehicles in files of their own",
}
_COLUMNS = "| key | unit | type | default | meaning |\n| --- | --- | --- | --- | --- |"


def key_page() -> str:
    """The page in Markdown."""
    shown: dict[int, str] = {}
    parts = [_HEAD]
    for title, declared in _kinds():
        sections = list(_tables("", declared, shown))
        if sections:
            parts += [f"## {title}\n", *sections]
    return "\n".join(parts)


def _kinds() -> Iterator[tuple[str, TableKey]]:
    for known in FORMATS:
        yield f"{known.title} ({_told_by(known)})", scenario_keys(known.tables)
    for kind, declared in OTHERS.items():
        yield _TITLES[kind], declared


def _told_by(known: FileFormat) -> str:
    key, values = "objective.kind", known.kinds
    if SPACECRAFT not in known.systems:
        key, values = "system", known.systems
    told = ", ".join(f'"{value}"' for value in values)
    return f"`{key}` = {told}"


def _tables(path: str, declared: TableKey, shown: dict[int, str]) -> Iterator[str]:
    """Tables of a file with their keys, but those that were shown before."""
    if declared.variants:
        for kind in declared.variants:
            found = declared.of({"kind": kind})
            yield _section(f'[{path}] with kind = "{kind}"', declared.meaning, found)
        return
    rows = {key: value for key, value in declared.items() if not _own_section(value)}
    if rows:
        name = f"[[{path}]]" if declared.many else f"[{path}]" if path else "At the top"
        yield _section(name, declared.meaning, TableKey(keys_=rows))
    inner = {key: value for key, value in declared.items() if _own_section(value)}
    if isinstance(declared.free, TableKey):
        inner["NAME"] = declared.free
    for key, value in inner.items():
        assert isinstance(value, TableKey)
        if id(value) not in shown:
            shown[id(value)] = path
            yield from _tables(f"{path}.{key}" if path else key, value, shown)


def _own_section(declared: Key) -> bool:
    return isinstance(declared, TableKey) and not declared.inline


def _section(name: str, meaning: str, keys: TableKey) -> str:
    rows = [_row(key, value) for key, value in keys.items()]
    return "\n".join(
        (f"### {name}\n", f"{meaning[:1].upper()}{meaning[1:]}.\n", _COLUMNS, *rows, "")
    )


def _row(key: str, declared: Key) -> str:
    name = f"**`{key}`**" if declared.required and not declared.unless else f"`{key}`"
    unit = next((unit for suffix, unit in UNITS.items() if key.endswith(suffix)), "")
    cells = (name, unit, declared.words(), _default(declared), declared.meaning)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _default(declared: Key) -> str:
    if declared.default is None:
        return declared.otherwise
    if isinstance(declared.default, bool):
        return str(declared.default).lower()
    if isinstance(declared.default, str):
        return f'`"{declared.default}"`'
    return f"{declared.default:g}" if isinstance(declared.default, float) else str(declared.default)
