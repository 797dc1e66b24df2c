"""One, few and many flights share a compiled size; very many fill larger chunks."""

import jax
import numpy as np
import pytest

from jaxatt.runtime.chunks import CHUNK, padded_chunks, rows_of_flights


def test_one_few_and_many_share_a_size(monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")
    (few,) = {rows_of_flights(count) for count in (1, 2, 17, 4 * CHUNK)}
    assert few < rows_of_flights(4 * CHUNK + 1) == CHUNK


def test_an_accelerator_gets_whole_chunks(monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert {rows_of_flights(count) for count in (1, 2, 10**5)} == {CHUNK}


@pytest.mark.parametrize("count", [1, 7, 8, 9, 65])
def test_no_flight_is_lost_or_counted_twice(count):
    rows = rows_of_flights(count)
    chunks = list(padded_chunks(np.arange(count), rows))
    assert {len(chunk) for chunk, _ in chunks} == {rows}
    kept = [chunk[:size] for chunk, size in chunks]
    np.testing.assert_array_equal(np.concatenate(kept), np.arange(count))
