"""What is declared of a key in a TOML file: type, range, default and meaning.

The reader's checks, the JSON schema and the table of keys in the documentation are all made from
these declarations.  The unit of a number is in the name of its key.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, ClassVar

Keys = Mapping[str, "Key"]
Schema = dict[str, Any]

_LARGEST_WHOLE = 2**31 - 1
_NUMBER: Schema = {"type": "number"}
_TEXT: Schema = {"type": "string", "pattern": r"\S"}
_TRIPLE: Schema = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}


@dataclass(frozen=True, eq=False)
class Key:
    """A key of any type; each type says what it is in words and in a JSON schema.

    reader : name of the method of `fields.Table` that reads such a value; empty where any will do.
    meaning : half a sentence on what it is.
    default : value that stands for it where it is left out; None where none does.
    otherwise : words on what stands for it, where that depends on other keys.
    required : whether it must be there.  unless : keys, one of which may stand for it.
    example : value for messages, as TOML has it.
    """

    meaning: str = ""
    _: KW_ONLY
    default: Any = None
    otherwise: str = ""
    required: bool = False
    unless: tuple[str, ...] = ()
    example: str = "1.0"
    reader: ClassVar[str] = ""

    def words(self) -> str:
        """Type and range."""
        return "any"

    def schema(self) -> Schema:
        """JSON schema of a value."""
        return {}


@dataclass(frozen=True, eq=False)
class Number(Key):
    """A finite number."""

    _: KW_ONLY
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    below: float | None = None
    reader: ClassVar[str] = "number"

    def words(self) -> str:
        return f"number{_range(self.above, self.at_least, self.at_most, self.below)}"

    def schema(self) -> Schema:
        return _bounds(self.above, self.at_least, self.at_most, self.below)


@dataclass(frozen=True, eq=False)
class Whole(Key):
    """A whole number; the largest is the one that compiled code can count with."""

    _: KW_ONLY
    at_least: int = 1
    at_most: int = _LARGEST_WHOLE
    example: str = "1"
    reader: ClassVar[str] = "integer"

    def words(self) -> str:
        most = None if self.at_most == _LARGEST_WHOLE else self.at_most
        return f"whole number{_range(None, self.at_least, most)}"

    def schema(self) -> Schema:
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


@dataclass(frozen=True, eq=False)
class Flag(Key):
    """True or false; false where it is left out, unless the default says otherwise."""

    _: KW_ONLY
    default: bool = False
    reader: ClassVar[str] = "flag"

    def words(self) -> str:
        return "true or false"

    def schema(self) -> Schema:
        return {"type": "boolean"}


@dataclass(frozen=True, eq=False)
class Text(Key):
    """A text that is not empty."""

    _: KW_ONLY
    example: str = '"..."'
    reader: ClassVar[str] = "text"

    def words(self) -> str:
        return "text"

    def schema(self) -> Schema:
        return _TEXT


@dataclass(frozen=True, eq=False)
class Texts(Key):
    """A list of texts that are not empty; `size` of them where that is given."""

    _: KW_ONLY
    size: int | None = None
    example: str = '["..."]'
    reader: ClassVar[str] = "texts"

    def words(self) -> str:
        return "list of texts" if self.size is None else f"{self.size} texts"

    def schema(self) -> Schema:
        return {"type": "array", "items": _TEXT, **_size(self.size)}


@dataclass(frozen=True, eq=False)
class Choice(Key):
    """One of some texts."""

    _: KW_ONLY
    options: tuple[str, ...] = ()
    reader: ClassVar[str] = "choice"

    def words(self) -> str:
        return ", ".join(f'`"{option}"`' for option in self.options)

    def schema(self) -> Schema:
        return {"enum": list(self.options)}


@dataclass(frozen=True, eq=False)
class Numbers(Key):
    """A list of finite numbers.

    size : how many; None where that depends on other keys.
    any_size : whether it is brought to unit length, so that numbers may be as large as they like.
    above : what each is greater than; None without a limit.
    """

    _: KW_ONLY
    size: int | None = None
    any_size: bool = False
    above: float | None = None
    reader: ClassVar[str] = "vector"

    def words(self) -> str:
        count = "list of" if self.size is None else str(self.size)
        return f"{count} numbers{_range(self.above)}"

    def schema(self) -> Schema:
        return {"type": "array", "items": _bounds(self.above), **_size(self.size)}


@dataclass(frozen=True, eq=False)
class Each(Key):
    """A positive number for all parts, or a list with one for each.

    zero, infinite : whether 0 and inf are allowed.  signed : whether negative ones are.
    at_most : the largest of them.
    """

    _: KW_ONLY
    zero: bool = False
    infinite: bool = False
    signed: bool = False
    at_most: float | None = None
    reader: ClassVar[str] = "each"

    def words(self) -> str:
        least = "" if self.signed else " >= 0" if self.zero else " > 0"
        return f"number, or one for each,{least}".rstrip(",")

    def schema(self) -> Schema:
        least = None if self.signed else 0.0
        item = _bounds(at_least=least) if self.zero else _bounds(least)
        return {"anyOf": [item, {"type": "array", "items": item, "minItems": 1}]}


@dataclass(frozen=True, eq=False)
class Rows(Key):
    """A list of rows of three numbers, one row for each part; of : what such a part is called."""

    _: KW_ONLY
    of: str = ""
    example: str = "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
    reader: ClassVar[str] = "rows"

    def words(self) -> str:
        return "rows of 3 numbers"

    def schema(self) -> Schema:
        return {"type": "array", "items": _TRIPLE, "minItems": 1}


@dataclass(frozen=True, eq=False)
class Matrix(Key):
    """Three rows of three numbers."""

    reader: ClassVar[str] = "matrix"

    def words(self) -> str:
        return "3 rows of 3 numbers"

    def schema(self) -> Schema:
        return {"type": "array", "items": _TRIPLE, **_size(3)}


@dataclass(frozen=True, eq=False)
class Either(Key):
    """A value of one of several forms."""

    _: KW_ONLY
    forms: tuple[Key, ...] = ()

    def words(self) -> str:
        return ", or ".join(form.words() for form in self.forms)


@dataclass(frozen=True, eq=False)
class TableKey(Key, Mapping[str, Key]):
    """A table, or a list of tables, with the keys that each may hold.

    many : whether it is a list of them, in double brackets.
    inline : whether it stands in braces, as a value of the table around it.
    apart : groups of keys, of each of which one at most may be given.
    named : whether messages tell such tables apart by their names, too.
    free : what any key that is not declared holds; None where there are none.
    variants : more keys, by the value of the key `kind`.
    """

    keys_: Keys = field(default_factory=dict)
    _: KW_ONLY
    many: bool = False
    inline: bool = False
    apart: tuple[tuple[str, ...], ...] = ()
    named: bool = False
    free: Key | None = None
    variants: Mapping[str, Keys] = field(default_factory=dict)

    def of(self, data: Any) -> TableKey:
        """The table with the keys of the kind that its data says, or of every kind."""
        if not self.variants:
            return self
        kind = data.get("kind") if isinstance(data, dict) else None
        chosen = [self.variants[kind]] if isinstance(kind, str) and kind in self.variants else []
        more = {
            key: value for keys in chosen or self.variants.values() for key, value in keys.items()
        }
        if not chosen:
            more = {key: Key(value.meaning) for key, value in more.items()}
        return replace(self, keys_={**self.keys_, **more}, variants={})

    def __getitem__(self, key: str) -> Key:
        return self.keys_[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys_)

    def __len__(self) -> int:
        return len(self.keys_)

    def words(self) -> str:
        return "tables" if self.many else "table in braces"


def _bounds(
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    below: float | None = None,
) -> Schema:
    found = {
        "exclusiveMinimum": above,
        "minimum": at_least,
        "maximum": at_most,
        "exclusiveMaximum": below,
    }
    return {**_NUMBER, **{name: limit for name, limit in found.items() if limit is not None}}


def _size(size: int | None) -> Schema:
    return {} if size is None else {"minItems": size, "maxItems": size}


def _range(
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    below: float | None = None,
) -> str:
    parts = (("> ", above), (">= ", at_least), ("<= ", at_most), ("< ", below))
    told = ", ".join(f"{sign}{limit:g}" for sign, limit in parts if limit is not None)
    return f" {told}" if told else ""
