"""Typed and checked reading of one TOML table, with error messages that say what is allowed."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, NoReturn, TypeVar

import numpy as np

from jaxatt.problems.reading.keys import (
    Choice,
    Each,
    Either,
    Flag,
    Key,
    Number,
    Numbers,
    Rows,
    TableKey,
    Texts,
    Whole,
)
from jaxatt.problems.reading.schema import nearest, unit_of, unknown_key_mend
from jaxatt.spacecraft.checks import (
    LARGEST,
    SMALLEST,
    FieldError,
    Float64,
    as_float,
    brief,
    finite_array,
    positive,
)

_TINY = 1e-12
"""Length of a vector that is no direction."""
LONGEST_S = 1e9
"""Longest time [s] in a scenario, about 30 years."""


K = TypeVar("K", bound=Key)


class ScenarioError(ValueError):
    """An error in a scenario: it names file, table, key and value, and says how to mend it.

    origin : the file.  label : the table as messages show it, empty at the top.  key : in it.
    All are empty where the message has no such place.
    """

    def __init__(self, message: str, origin: str = "", label: str = "", key: str = "") -> None:
        super().__init__(message)
        self.origin, self.label, self.key = origin, label, key


class ScenarioErrors(ScenarioError):
    """Several errors, one a line of the message."""

    def __init__(self, errors: Sequence[ScenarioError]) -> None:
        super().__init__("\n".join(map(str, errors)))
        self.errors = tuple(errors)


def shown(value: Any) -> str:
    """Return a short TOML-like text of a value, for messages."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    else:
        text = brief(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def missing_table(name: str, origin: str) -> ScenarioError:
    """Return the error that a table is not in a file."""
    return ScenarioError(
        f"{origin}: [{name}] is missing; `jaxatt scenarios show NAME` prints a complete file to "
        "start from",
        origin,
        "",
        name,
    )


class Table:
    """One table of a scenario file; unknown keys are refused at once.

    Parameters
    ----------
    data : object
        What the file holds under this name.
    origin : str
        The file, for messages.
    label : str
        The table as messages show it, e.g. ``"[horizon]"``; empty at the top of the file.
    keys : collection of str
        The keys it may hold; a `TableKey` says their types, ranges and defaults, too.
    """

    def __init__(self, data: Any, origin: str, label: str, keys: Collection[str]) -> None:
        self.origin = origin
        self.label = label
        self.keys = keys if isinstance(keys, Mapping) else dict.fromkeys(keys, Key())
        name = label.strip("[]").split("]")[0]
        if not isinstance(data, dict):
            raise ScenarioError(
                f"{origin}: {label}: {shown(data)} is not a table; write [{name}] on a line of its "
                "own and its keys below",
                origin,
                label,
            )
        self.data: dict[str, Any] = data
        free = isinstance(keys, TableKey) and keys.free is not None
        for key, value in data.items():
            if key not in keys and not free:
                kind = "unknown table" if isinstance(value, dict) else "unknown key"
                self.fail(key, kind, unknown_key_mend(name, key, keys))
        for group in keys.apart if isinstance(keys, TableKey) else ():
            given = [key for key in group if key in data]
            if len(given) > 1:
                self.fail(
                    given[1],
                    f"given beside {given[0]}",
                    "keep one of the two and drop the other",
                )

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def where(self, key: str) -> str:
        """Return file, table and key, with which messages begin."""
        return f"{self.origin}: {self.label} {key}" if self.label else f"{self.origin}: {key}"

    def fail(self, key: str, problem: str, mend: str) -> NoReturn:
        """Raise a `ScenarioError` about a key."""
        value = self.data.get(key)
        stated = key in self.data and not isinstance(value, dict)
        assigned = f" = {shown(value)}" if stated else ""
        message = f"{self.where(key)}{assigned}: {problem}; {mend}"
        raise ScenarioError(message, self.origin, self.label, key)

    def declared(self, key: str, kind: type[K]) -> K:
        """Return what is declared of a key that is read as one kind; nothing where it is not."""
        found = self.keys.get(key)
        forms = found.forms if isinstance(found, Either) else (found,)
        return next((form for form in forms if isinstance(form, kind)), kind())

    def default(self, key: str) -> Any:
        """Return the value that is declared to stand for a key that is left out, or None."""
        found = self.keys.get(key)
        return None if found is None else found.default

    def require(self, key: str) -> Any:
        """Return the value of a key that must be there."""
        if key not in self.data:
            found = self.keys.get(key, Key())
            instead = f", or give {' or '.join(found.unless)}" if found.unless else ""
            self.fail(key, "missing", f"add a line such as {key} = {found.example}{instead}")
        return self.data[key]

    def one_of(self, keys: tuple[str, ...]) -> str:
        """Return the one of these keys, each of which states a direction, that is given."""
        given = [key for key in keys if key in self.data]
        if len(given) != 1:
            key = given[1] if given else "toward"
            problem = f"given beside {given[0]}" if given else "no direction is given"
            self.fail(key, problem, f"give exactly one of {', '.join(keys)}")
        return given[0]

    def direction(self, key: str) -> Float64:
        """Return a vector (3,) of any length as a unit vector."""
        vector = self.vector(key, 3)
        size = float(np.linalg.norm(vector))
        if not size > _TINY:
            self.fail(
                key, "is zero, which is no direction", "give a vector such as [0.0, 0.0, 1.0]"
            )
        return np.asarray(vector / size)

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number; without a default, here or declared, the key must be there."""
        if key not in self.data:
            default = self.default(key) if default is None else default
            if default is not None:
                return default
        result = self._finite(key, self.require(key))
        found = self.declared(key, Number)
        unit = unit_of(key)
        units = f" in {unit}" if unit else ""
        above, at_least, at_most = found.above, found.at_least, found.at_most
        if above == 0.0 < result < SMALLEST:
            self.fail(key, f"must be at least {SMALLEST:g}", f"give a larger number{units}")
        if above is not None and not result > above:
            self.fail(key, f"must be greater than {above:g}", f"give a larger number{units}")
        if at_least is not None and not result >= at_least:
            self.fail(key, f"must be at least {at_least:g}", f"give a larger number{units}")
        if at_most is not None and not result <= at_most:
            self.fail(key, f"must be at most {at_most:g}", f"give a smaller number{units}")
        if found.below is not None and not result < found.below:
            self.fail(key, f"must be less than {found.below:g}", f"give a smaller number{units}")
        return result

    def integer(self, key: str, default: int | None = None) -> int:
        """Return a whole number."""
        if key not in self.data:
            default = self.default(key) if default is None else default
            if default is not None:
                return default
        value = self.require(key)
        found = self.declared(key, Whole)
        if isinstance(value, bool) or not isinstance(value, int):
            self.fail(key, "must be a whole number", "write it without quotes and decimal point")
        if value < found.at_least:
            self.fail(key, f"must be at least {found.at_least}", "give a larger whole number")
        if value > found.at_most:
            self.fail(key, f"must be at most {found.at_most}", "give a smaller whole number")
        return int(value)

    def flag(self, key: str) -> bool:
        """Return true or false."""
        value = self.data.get(key, self.declared(key, Flag).default)
        if not isinstance(value, bool):
            self.fail(key, "must be true or false", "write it in lower case, without quotes")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text that is not empty, or the default."""
        if key not in self.data:
            default = self.default(key) if default is None else default
            if default is not None:
                return default
        value = self.require(key)
        if not isinstance(value, str) or not value.strip():
            self.fail(key, "must be a text", "write it in quotes")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of texts that are not empty; none without the key."""
        found = self.declared(key, Texts)
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) and v.strip() for v in value):
            self.fail(key, "must be a list of texts", f"write {key} = {found.example}")
        if found.size is not None and len(value) != found.size:
            self.fail(key, f"has {len(value)} texts", f"write {key} = {found.example}")
        return tuple(value)

    def choice(self, key: str, default: str | None = None) -> str:
        """Return one of the options; without a default, here or declared, the key must be there."""
        options = self.declared(key, Choice).options
        if key not in self.data:
            default = self.default(key) if default is None else default
        value = self.require(key) if default is None else self.data.get(key, default)
        if value not in options or not isinstance(value, str):
            near = nearest(value, options) if isinstance(value, str) else None
            hint = f"did you mean '{near}'? " if near else ""
            self.fail(key, "not one of the choices", f"{hint}allowed: {', '.join(options)}")
        return value

    def vector(self, key: str, size: int | None = None, default: Float64 | None = None) -> Float64:
        """Return a list of finite numbers, (size,); the size is the declared one by default."""
        found = self.declared(key, Numbers)
        size = found.size if size is None else size
        if key not in self.data:
            default = self.default(key) if default is None else default
            if default is not None:
                return np.array(default, np.float64)
            if size is not None and found.example == Key.example:
                self.fail(key, "missing", f"add a line such as {key} = {[0.0] * size}")
        value = self.require(key)
        if not isinstance(value, list):
            many = "" if size is None else f"{size} "
            self.fail(key, "must be a list", f"write {many}numbers in brackets")
        if size is not None and len(value) != size:
            self.fail(key, f"has {len(value)} entries", f"give {size} numbers")
        result = np.array([self._finite(key, item, any_size=found.any_size) for item in value])
        if found.above is not None and not (result > found.above).all():
            self.fail(key, f"must be greater than {found.above:g}", "give larger numbers")
        return result

    def rows(self, key: str) -> Float64:
        """Return a list with one row of three numbers for each part, as columns (3, n)."""
        given = self.require(key)
        if not isinstance(given, list) or not all(
            isinstance(row, list) and len(row) == 3 for row in given
        ):
            of = self.declared(key, Rows).of
            self.fail(
                key, f"is not a list of {key}", f"give one row of three numbers for each {of}"
            )
        try:
            numbers = [[as_float(item) for item in row] for row in given]
        except TypeError:
            self.fail(key, "holds something that is no number", "give plain numbers")
        return np.array(numbers).reshape(-1, 3).T

    def each(self, key: str) -> Float64:
        """Return a number for all parts, or a list with one for each."""
        found = self.declared(key, Each)
        array = self._array(key, found.infinite)
        try:
            return array if found.signed else positive(key, array, zero=found.zero)
        except FieldError as error:
            self.fail(key, *error.problem_and_mend)

    def matrix(self, key: str) -> Float64:
        """Return three rows of three numbers."""
        array = self._array(key)
        if array.shape != (3, 3):
            self.fail(key, f"has shape {array.shape}", "give three rows of three numbers")
        return array

    def _array(self, key: str, infinite: bool = False) -> Float64:
        try:
            return finite_array(key, self.require(key), infinite=infinite)
        except FieldError as error:
            self.fail(key, *error.problem_and_mend)

    def _finite(self, key: str, value: Any, *, any_size: bool = False) -> float:
        unit = unit_of(key)
        try:
            number = as_float(value)
        except TypeError:
            told = f": the key says that it is in {unit}" if unit else ""
            self.fail(
                key,
                f"{shown(value)} is not a number",
                f"write a plain number without quotes or unit{told}",
            )
        units = f" in {unit}" if unit else ""
        if not math.isfinite(number):
            self.fail(key, "must be finite", f"give a number{units}")
        largest = LONGEST_S if unit == "seconds" else LARGEST
        if abs(number) > largest and not any_size:
            beyond = ", 30 years" if unit == "seconds" else ""
            self.fail(key, f"is beyond {largest:g}{beyond}", f"give a smaller number{units}")
        return number
