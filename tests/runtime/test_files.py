"""Folders are checked beforehand; files appear whole or not at all."""

import json

import pytest

from jaxatt.runtime.files import OutputError, filling, prepare_folder, replacing
from jaxatt.runtime.json_files import write_json


def test_a_folder_that_can_be_made_leaves_no_trace(tmp_path):
    prepare_folder(tmp_path / "new" / "deeper")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_below_a_file_is_refused(tmp_path):
    (tmp_path / "taken").write_text("")
    for path in (tmp_path / "taken", tmp_path / "taken" / "below"):
        with pytest.raises(OutputError, match="nothing can be written there"):
            prepare_folder(path)


def test_a_file_that_fails_half_way_keeps_the_old_one(tmp_path):
    path = tmp_path / "old.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), replacing(path) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["old.txt"]


def test_a_folder_that_fails_half_way_stays_empty(tmp_path):
    with pytest.raises(KeyboardInterrupt), filling(tmp_path / "out") as partial:
        (partial / "first.txt").write_text("whole")
        raise KeyboardInterrupt
    assert list((tmp_path / "out").iterdir()) == []


def test_json_holds_no_nan(tmp_path):
    write_json({"x": float("nan"), "y": [1.0, float("inf")]}, tmp_path / "x.json")
    assert json.loads((tmp_path / "x.json").read_text()) == {"x": None, "y": [1.0, None]}
