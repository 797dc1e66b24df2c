"""How many starts of a programme over stages make one chunk."""

import pytest

from jaxatt.multistart import staged_chunks
from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.runtime import chunks


@pytest.fixture(autouse=True)
def _two_cores(monkeypatch):
    monkeypatch.setattr(chunks, "workers", lambda: 2)


@pytest.mark.parametrize(
    ("count", "intervals", "rows"),
    [(1, 35, 1), (2, 35, 1), (3, 35, 2), (1000, 35, 8), (1000, 90, 4), (64, 500, 1), (64, 2190, 1)],
)
def test_chunks_keep_to_the_cores_and_their_cache(count, intervals, rows):
    assert rows_of_stages(count, intervals) == rows


def test_two_accelerators_get_half_of_all_starts_each(monkeypatch):
    monkeypatch.setattr(staged_chunks.jax, "default_backend", lambda: "gpu")
    assert rows_of_stages(64, 2190) == 32
