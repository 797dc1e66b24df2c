"""What a store of samples holds: coordinates, columns, and what tells it from other stores."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.records.labels import Variable

SAMPLE, DONE = "sample", "done"
"""Dimension of all columns, and the column that says which samples are written."""

STRING = "string"

_NAME = re.compile(r"[^\W\d_][\w.-]{0,199}")
_TEXT_BYTES, _FILE_BYTES = 100, 4096


@dataclass(frozen=True)
class Column:
    """One quantity of every sample.

    dtype : "float64", "int64", "int8", "bool" or "string".  dims, shape : of one sample, none for
    a number.  Not yet written are NaN, 0, false and "".
    """

    dtype: str = "float64"
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Layout:
    """Coordinates and columns of S samples, written `chunk` samples at a time.

    identity : texts that must agree where a store is continued or merged, such as a hash of the
    study and the versions of packages; messages call them by their names.
    coordinates : name -> (dimensions, values, attributes); those of every sample have the
    dimension "sample" alone.  attributes : of the whole store, texts.

    Raises `ScenarioError` where names clash or are no names.
    """

    samples: int
    chunk: int
    identity: Mapping[str, str]
    coordinates: Mapping[str, Variable]
    columns: Mapping[str, Column]
    attributes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.samples < 1 or self.chunk < 1:
            raise ScenarioError(
                f"samples = {self.samples}, chunk = {self.chunk}: a store needs at least 1 of each"
            )
        for name in (*self.coordinates, *self.columns):
            if not _NAME.fullmatch(name):
                raise ScenarioError(
                    f"{name!r}: no name for a column of a store; use at most 200 letters, digits, "
                    "'_', '.' and '-', and begin with a letter"
                )
        both = {SAMPLE, DONE, *self.coordinates} & {*self.columns} | {DONE} & {*self.coordinates}
        if both:
            raise ScenarioError(
                f"{', '.join(sorted(both))}: names more than one column; give the swept field "
                "another name"
            )

    @property
    def chunks(self) -> int:
        """Number of chunks; the last may be shorter."""
        return -(-self.samples // self.chunk)

    def rows(self, chunk: int) -> slice:
        """Samples of a chunk."""
        return slice(chunk * self.chunk, min(self.samples, (chunk + 1) * self.chunk))

    def samples_of(self, share: tuple[int, int]) -> int:
        """Number of samples of task i of n = `share`."""
        return sum(rows.stop - rows.start for rows in map(self.rows, self.chunks_of(share)))

    def chunks_of(self, share: tuple[int, int]) -> range:
        """Chunks of task i of n = `share`: i, i + n, i + 2 n, ..."""
        first, every = share
        return range(first, self.chunks, every)

    @property
    def bytes(self) -> int:
        """Room that the whole store may take on a disk, without compression."""
        whole = {name: math.prod(c.shape) * self.samples for name, c in self.columns.items()}
        size = {"float64": 8, "int64": 8, STRING: _TEXT_BYTES}
        data = sum(whole[name] * size.get(c.dtype, 1) for name, c in self.columns.items())
        sampled = len(list(self.of_samples())) * 8 * self.samples
        files = (len(self.columns) + 1) * self.chunks
        return data + sampled + _FILE_BYTES * files

    def of_samples(self) -> Iterator[str]:
        """Names of the coordinates that every sample has a value of."""
        return (name for name, (dims, _, _) in self.coordinates.items() if tuple(dims) == (SAMPLE,))
