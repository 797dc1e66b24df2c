"""Typed and checked reading of one TOML table, with error messages that say what is allowed."""

from __future__ import annotations

import math
from typing import Any, NoReturn

import numpy as np

from jaxatt.problems.reading.schema import nearest, unit_of, unknown_key_mend
from jaxatt.spacecraft.checks import LARGEST, SMALLEST, Float64, as_float, brief

_TINY = 1e-12
"""Length of a vector that is no direction."""
LONGEST_S = 1e9
"""Longest time [s] in a scenario, about 30 years."""


class ScenarioError(ValueError):
    """An error in a scenario: it names file, table, key and value, and says how to mend it."""


def shown(value: Any) -> str:
    """Return a short TOML-like text of a value, for messages."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    else:
        text = brief(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


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
    keys : tuple of str
        The keys it may hold.
    """

    def __init__(self, data: Any, origin: str, label: str, keys: tuple[str, ...]) -> None:
        self.origin = origin
        self.label = label
        name = label.strip("[]").split("]")[0]
        if not isinstance(data, dict):
            raise ScenarioError(
                f"{origin}: {label}: {shown(data)} is not a table; write [{name}] on a line of its "
                "own and its keys below"
            )
        self.data: dict[str, Any] = data
        for key, value in data.items():
            if key not in keys:
                kind = "unknown table" if isinstance(value, dict) else "unknown key"
                self.fail(key, kind, unknown_key_mend(name, key, keys))

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
        raise ScenarioError(f"{self.where(key)}{assigned}: {problem}; {mend}")

    def require(self, key: str, example: str) -> Any:
        """Return the value of a key that must be there."""
        if key not in self.data:
            self.fail(key, "missing", f"add a line such as {key} = {example}")
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

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        example: str = "1.0",
    ) -> float:
        """Return a finite number; without a default the key must be there."""
        if key not in self.data and default is not None:
            return default
        result = self._finite(key, self.require(key, example))
        unit = unit_of(key)
        units = f" in {unit}" if unit else ""
        if above == 0.0 < result < SMALLEST:
            self.fail(key, f"must be at least {SMALLEST:g}", f"give a larger number{units}")
        if above is not None and not result > above:
            self.fail(key, f"must be greater than {above:g}", f"give a larger number{units}")
        if at_least is not None and not result >= at_least:
            self.fail(key, f"must be at least {at_least:g}", f"give a larger number{units}")
        if at_most is not None and not result <= at_most:
            self.fail(key, f"must be at most {at_most:g}", f"give a smaller number{units}")
        return result

    def integer(
        self,
        key: str,
        default: int | None = None,
        *,
        at_least: int = 1,
        at_most: int = 2**31 - 1,
    ) -> int:
        """Return a whole number; the largest is the one that compiled code can count with."""
        if key not in self.data and default is not None:
            return default
        value = self.require(key, str(max(at_least, 1)))
        if isinstance(value, bool) or not isinstance(value, int):
            self.fail(key, "must be a whole number", "write it without quotes and decimal point")
        if value < at_least:
            self.fail(key, f"must be at least {at_least}", "give a larger whole number")
        if value > at_most:
            self.fail(key, f"must be at most {at_most}", "give a smaller whole number")
        return int(value)

    def flag(self, key: str, default: bool = False) -> bool:
        """Return true or false."""
        value = self.data.get(key, default)
        if not isinstance(value, bool):
            self.fail(key, "must be true or false", "write it in lower case, without quotes")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text that is not empty, or the default."""
        if key not in self.data and default is not None:
            return default
        value = self.require(key, '"..."')
        if not isinstance(value, str) or not value.strip():
            self.fail(key, "must be a text", "write it in quotes")
        return value

    def texts(self, key: str, example: str) -> tuple[str, ...]:
        """Return a list of texts that are not empty; none without the key."""
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) and v.strip() for v in value):
            self.fail(key, "must be a list of texts", f"write {key} = {example}")
        return tuple(value)

    def choice(self, key: str, options: tuple[str, ...], default: str) -> str:
        """Return one of the options."""
        value = self.data.get(key, default)
        if value not in options or not isinstance(value, str):
            near = nearest(value, options) if isinstance(value, str) else None
            hint = f"did you mean '{near}'? " if near else ""
            self.fail(key, "not one of the choices", f"{hint}allowed: {', '.join(options)}")
        return value

    def vector(
        self, key: str, size: int, default: Float64 | None = None, *, scaled: bool = False
    ) -> Float64:
        """Return a list of `size` finite numbers, (size,).

        scaled : whether it is brought to unit length, so that its size does not matter.
        """
        if key not in self.data and default is not None:
            return default
        value = self.require(key, str([0.0] * size))
        if not isinstance(value, list):
            self.fail(key, "must be a list", f"write {size} numbers in brackets")
        if len(value) != size:
            self.fail(key, f"has {len(value)} entries", f"give {size} numbers")
        return np.array([self._finite(key, item, any_size=scaled) for item in value])

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
