"""Find all faults of a document that can be told from what is declared of its keys."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError, ScenarioErrors, Table, missing_table
from jaxatt.problems.reading.keys import Choice, Either, Key, TableKey
from jaxatt.problems.reading.schema import nearest


def refuse_faults(document: Mapping[str, Any], origin: str, declared: TableKey) -> None:
    """Raise `ScenarioErrors` with all faults of a document, if it has any."""
    refuse(find_faults(document, origin, declared))


def refuse(faults: Sequence[ScenarioError]) -> None:
    """Raise the faults that were found, if there are any."""
    if faults:
        raise faults[0] if len(faults) == 1 else ScenarioErrors(faults)


def find_faults(
    document: Mapping[str, Any], origin: str, declared: TableKey
) -> list[ScenarioError]:
    """All faults of a document, in the order of the file; no fault follows from another."""
    return list(_in_table(document, origin, "", "", declared))


def _in_table(
    data: Any, origin: str, label: str, path: str, declared: TableKey
) -> Iterator[ScenarioError]:
    """Faults of one table and of those within."""
    declared = declared.of(data)
    rest, left_out = data, set()
    while True:
        try:
            table = Table(rest, origin, label, declared)
            break
        except ScenarioError as fault:
            yield fault
            if not isinstance(data, dict):
                return
            left_out.add(fault.key)
            rest = {key: value for key, value in data.items() if key not in left_out}
    for key, value in table.data.items():
        yield from _in_value(table, key, value, declared.get(key, declared.free), path)
    meant = {nearest(key, declared) for key in left_out}
    for key, wanted in declared.items():
        stands = any(other in data for other in (key, *wanted.unless)) or key in meant
        if wanted.required and not stands:
            if isinstance(wanted, TableKey) and not label:
                yield missing_table(key, origin)
            else:
                yield from _fault(partial(table.require, key))


def _in_value(
    table: Table, key: str, value: Any, declared: Key | None, path: str
) -> Iterator[ScenarioError]:
    """Faults of the value of one key."""
    if isinstance(declared, Either):
        declared = _form(value, declared)
    if not isinstance(declared, TableKey):
        yield from _fault(lambda: _read(table, key, declared))
        return
    whole = f"{path}.{key}" if path else key
    if declared.inline:
        yield from _in_table(value, table.origin, f"{table.label} {key}", whole, declared)
    elif not declared.many:
        yield from _in_table(value, table.origin, f"[{whole}]", whole, declared)
    elif not isinstance(value, list) or (declared.required and not value):
        yield ScenarioError(
            f"{table.where(key)}: must be a list of tables; write [[{whole}]] with double brackets",
            table.origin,
            table.label,
            key,
        )
    else:
        for index, item in enumerate(value):
            label = entry_label(whole, index, item, declared)
            yield from _in_table(item, table.origin, label, whole, declared)


def entry_label(path: str, index: int, data: Any, declared: TableKey) -> str:
    """What messages call one of several tables: its number, and its name where it has one."""
    name = data.get("name") if declared.named and isinstance(data, dict) else None
    named = f' "{name}"' if isinstance(name, str) else ""
    return f"[[{path}]] no. {index + 1}{named}"


def _fault(read: Callable[[], Any]) -> Iterator[ScenarioError]:
    try:
        read()
    except ScenarioError as fault:
        yield fault


def _form(value: Any, declared: Either) -> Key:
    """The form of a value that may have several: the last one, a list, or a text that is one."""
    single, listed = declared.forms[0], declared.forms[-1]
    fits = isinstance(value, str) if isinstance(listed, Choice) else isinstance(value, list)
    return listed if fits else single


def _read(table: Table, key: str, declared: Key | None) -> None:
    """Read a value as it is declared, to see whether that is refused."""
    if declared is not None and declared.reader:
        getattr(table, declared.reader)(key)
