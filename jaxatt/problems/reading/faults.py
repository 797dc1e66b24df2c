"""Collect the faults of a document's parts, each of which is read by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.fields import ScenarioError, ScenarioErrors

P = ParamSpec("P")
T = TypeVar("T")


class _Unsound:
    """Stands for what could not be read, and for whatever is asked of it."""

    def __getattr__(self, name: str) -> _Unsound:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __bool__(self) -> bool:
        raise TypeError("what could not be read has no value: ask for it through `Faults.of`")


UNSOUND: Any = _Unsound()


class Faults:
    """Faults found so far; reading goes on with what does not depend on them.

    told : those that were found before anything is read.
    """

    def __init__(self, told: Sequence[ScenarioError] = ()) -> None:
        self.found = list(told)

    def of(self, read: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """What `read` returns, or a stand-in where it, or an argument of it, has a fault."""
        if any(part is UNSOUND for part in (*args, *kwargs.values())):
            unsound: T = UNSOUND
            return unsound
        try:
            return read(*args, **kwargs)
        except ScenarioError as error:
            self.add(error)
            stand_in: T = UNSOUND
            return stand_in

    def add(self, error: ScenarioError) -> None:
        """Keep the faults of an error, but for those of keys that have one already."""
        for fault in error.errors if isinstance(error, ScenarioErrors) else (error,):
            if not any(_same(fault, other) for other in self.found):
                self.found.append(fault)

    def or_else(self, part: T, instead: T) -> T:
        """A part, or what reading goes on with where it is a stand-in: its faults are raised."""
        return instead if part is UNSOUND else part

    def table(self, document: Mapping[str, Any], name: str) -> Any:
        """A table that must be there; a stand-in where it is told to be missing."""
        return document.get(name, UNSOUND)

    def refuse(self) -> None:
        """Raise all faults, if there are any."""
        refuse(self.found)


def _same(one: ScenarioError, other: ScenarioError) -> bool:
    return str(one) == str(other) or bool(one.key and _place(one) == _place(other))


def _place(fault: ScenarioError) -> tuple[str, str, str]:
    """File, table and key; the tables of a vehicle are called alike in a file of its own."""
    label = fault.label.removeprefix("[vehicle]").replace("[vehicle.", "[")
    return fault.origin, label, fault.key
