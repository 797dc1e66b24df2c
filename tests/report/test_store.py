"""The store of samples: resumed, merged, opened while it grows, refused where it does not fit."""

from __future__ import annotations

import dataclasses
import errno
import pathlib

import numpy as np
import pytest
import xarray

from jaxatt.report.store.dataset import open_store
from jaxatt.report.store.layout import Column, Layout
from jaxatt.report.store.merge import merge
from jaxatt.report.store.store import Store
from jaxatt.runtime.files import OutputError
from jaxatt.scenarios import ScenarioError

SAMPLES, CHUNK = 11, 3


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1129)


@pytest.fixture
def values(rng: np.random.Generator) -> dict[str, np.ndarray]:
    number = rng.normal(size=SAMPLES)
    number[rng.integers(SAMPLES)] = np.nan
    return {
        "number": number,
        "count": rng.integers(100, size=SAMPLES),
        "words": np.array([f"sample {k} µ" for k in range(SAMPLES)], object),
        "torque": rng.normal(size=(SAMPLES, 4, 3)),
    }


@pytest.fixture
def layout(rng: np.random.Generator) -> Layout:
    return Layout(
        SAMPLES,
        CHUNK,
        {"study": "abc", "jaxatt": "1"},
        {
            "limit": (("sample",), rng.random(SAMPLES), {"units": "N m"}),
            "axis": (("axis",), np.array(["x", "y", "z"]), {}),
        },
        {
            "number": Column(attributes={"units": "s"}),
            "count": Column("int64"),
            "words": Column("string"),
            "torque": Column(dims=("interval", "axis"), shape=(4, 3)),
        },
        {"title": "a title"},
    )


def fill(store: Store, values: dict[str, np.ndarray], chunks: list[int]) -> None:
    for chunk in chunks:
        rows = store.layout.rows(chunk)
        store.write(chunk, {name: column[rows] for name, column in values.items()})


def same(path, values: dict[str, np.ndarray]) -> bool:
    found = open_store(path).load()
    return all(
        np.array_equal(found[name].values, column, equal_nan=column.dtype.kind == "f")
        for name, column in values.items()
    )


def test_grows_and_is_opened_by_xarray_alone(tmp_path, layout, values) -> None:
    path = tmp_path / "a.zarr"
    with Store.open_or_create(path, layout) as store:
        assert store.pending() == [0, 1, 2, 3] and not store.complete
        fill(store, values, [1, 3])
        growing = xarray.open_zarr(path, chunks=None).load()
    assert growing.done.values.tolist() == [False] * 3 + [True] * 3 + [False] * 3 + [True] * 2
    assert np.isnan(growing.number[:3]).all() and growing["count"][6] == 0
    assert growing.words[0] == "" and growing.words[10] == values["words"][10]
    assert set(growing.coords) == {"limit", "axis"} and growing.limit.attrs["units"] == "N m"
    np.testing.assert_array_equal(growing.torque.sel(axis="y")[9:], values["torque"][9:, :, 1])
    with Store.open_or_create(path, layout) as store:
        assert store.pending() == [0, 2] and store.pending((0, 2)) == [0, 2]
        assert store.pending((1, 2)) == []
        fill(store, values, store.pending())
        assert store.complete
    assert same(path, values)


def test_what_a_killed_process_left_is_removed(tmp_path, layout, values) -> None:
    path = tmp_path / "a.zarr"
    with Store.open_or_create(path, layout) as store:
        fill(store, values, [0])
    left = path / "number" / "c" / "1.0123456789abcdef.partial"
    left.write_bytes(b"half")
    with Store.open_or_create(path, layout) as store:
        assert not left.exists() and store.pending() == [1, 2, 3]


def test_merged_tasks_equal_one_run(tmp_path, layout, values) -> None:
    parts = [tmp_path / f"{k}.zarr" for k in range(3)]
    for k, path in enumerate(parts):
        with Store.open_or_create(path, layout) as store:
            fill(store, values, store.pending((k, 3)))
    found = merge(parts[:2], tmp_path / "whole.zarr")
    assert (found.done, found.samples) == (SAMPLES - CHUNK, SAMPLES)
    merge(parts[2:], found.path)
    assert same(found.path, values)
    merge(parts, tmp_path / "whole.zarr")  # again changes nothing
    assert same(tmp_path / "whole.zarr", values)


def test_merge_refuses_what_differs(tmp_path, layout, values) -> None:
    one, two = tmp_path / "one.zarr", tmp_path / "two.zarr"
    with Store.open_or_create(one, layout) as store:
        fill(store, values, [0])
    moved = np.nextafter(layout.coordinates["limit"][1], 2.0)
    clash = {**layout.coordinates, "limit": (("sample",), moved, {})}
    with Store.open_or_create(two, dataclasses.replace(layout, coordinates=clash)):
        pass
    with pytest.raises(OutputError, match=r"two.zarr: its coordinates limit are others"):
        merge([one, two], tmp_path / "out.zarr")
    changed = {**values, "count": values["count"] + 1}
    three = tmp_path / "three.zarr"
    with Store.open_or_create(three, layout) as store:
        fill(store, changed, [0])
    with pytest.raises(OutputError, match=r"three.zarr: count of samples 0 to 2 differs"):
        merge([one, three], tmp_path / "out.zarr")
    with pytest.raises(OutputError, match="is merged itself"):
        merge([one], one)


def test_refuses_stores_of_others(tmp_path, layout) -> None:
    path = tmp_path / "a.zarr"
    with (
        Store.open_or_create(path, layout),
        pytest.raises(OutputError, match="another process is writing"),
        Store.open_or_create(path, layout),
    ):
        pass
    later = dataclasses.replace(layout, identity={"study": "abc", "jaxatt": "2"})
    with pytest.raises(OutputError, match="holds jaxatt 1, not 2"):
        Store.open_or_create(path, later)
    fewer = dataclasses.replace(layout, columns={"number": Column()})
    with pytest.raises(OutputError, match=r"other columns \(count, number, torque, words\)"):
        Store.open_or_create(path, fewer)
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(OutputError, match="no store of samples"):
        Store.open_or_create(other, layout)
    with pytest.raises(OutputError, match="no such store"):
        open_store(tmp_path / "none.zarr")


def test_refuses_what_no_disk_holds(tmp_path, layout) -> None:
    shape = (10**6, 10**6)
    vast = {**layout.columns, "vast": Column(dims=("a", "b"), shape=shape)}
    with pytest.raises(OutputError, match="GB left"):
        Store.open_or_create(tmp_path / "a.zarr", dataclasses.replace(layout, columns=vast))
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_said_and_the_store_continues(tmp_path, layout, values, monkeypatch) -> None:
    path = tmp_path / "a.zarr"
    with Store.open_or_create(path, layout) as store:
        fill(store, values, [0])

        def full(*_: object) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(pathlib.Path, "replace", full)
        with pytest.raises(OutputError, match=r"a.zarr: cannot be written \(No space left"):
            fill(store, values, [1])
        monkeypatch.undo()
        assert store.pending() == [1, 2, 3]
        fill(store, values, [1, 2, 3])
    assert same(path, values)


@pytest.mark.parametrize("name", ["done", "limit", "sample", "", "a/b", "n" * 300])
def test_refuses_names(layout, name: str) -> None:
    with pytest.raises(ScenarioError, match="name"):
        dataclasses.replace(layout, columns={**layout.columns, name: Column()})
