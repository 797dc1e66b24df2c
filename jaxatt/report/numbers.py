"""Numbers of an answer by their names in `summary.json`, such as `starts.reached_target`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.schema import nearest

CLOCK = "time_s"
"""Table of a summary that differs from run to run, and is no output."""

_MISSING = object()


def number_at(summary: Mapping[str, Any], name: str) -> float:
    """The number of this name; NaN where it is null, or not there in this answer."""
    found = _at(summary, name)
    return float(found) if isinstance(found, (bool, int, float)) else float("nan")


def check_outputs(summary: Mapping[str, Any], names: Sequence[str], origin: str) -> None:
    """Refuse names that are no numbers of an answer, with `ScenarioError`; null may be one."""
    for name in names:
        found = _at(summary, name)
        if found is None or isinstance(found, (bool, int, float)):
            continue
        label = f"{origin}: outputs: {name}"
        if found is _MISSING:
            known = list(_numbers(summary, ""))
            near = nearest(name, known)
            short = [each for each in known if not each.rpartition(".")[2].isdecimal()]
            has = f"it has {', '.join(short)}; the state of a sample is kept anyway"
            hint = f"did you mean '{near}'?" if near else has
            raise ScenarioError(f"{label}: a summary of this scenario has no such number; {hint}")
        if isinstance(found, str):
            raise ScenarioError(
                f"{label}: is a text; drop it, the state of a sample is kept anyway"
            )
        inner = list(_numbers(found, name))
        hint = f"write one of {', '.join(inner[:8])}" if inner else "drop it"
        raise ScenarioError(f"{label}: holds several values, and an output is one number; {hint}")


def _at(summary: Mapping[str, Any], name: str) -> Any:
    """Value of a name; None below a null, as below `quantised` of a vehicle without thrusters."""
    found: Any = summary
    for part in name.split("."):
        if isinstance(found, Mapping):
            found = found.get(part, _MISSING)
        elif isinstance(found, list) and part.isdecimal() and int(part) < len(found):
            found = found[int(part)]
        elif found is not None:
            return _MISSING
    return found


def _numbers(value: Any, before: str) -> Iterator[str]:
    """Names of all numbers, save a clock's."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if key != CLOCK or before:
                yield from _numbers(item, f"{before}.{key}" if before else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, f"{before}.{index}")
    elif value is None or isinstance(value, (bool, int, float)):
        yield before
