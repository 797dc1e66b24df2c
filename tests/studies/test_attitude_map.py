"""Maps over all turns: run, shared out, resumed, drawn, and opened again."""

import json
import math

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.runtime.files import OutputError
from jaxatt.scenarios import ScenarioError
from jaxatt.studies.attitude_map import run as run_module
from jaxatt.studies.attitude_map import study as study_module
from jaxatt.studies.attitude_map.map import attitude_map
from jaxatt.studies.attitude_map.targets import map_targets
from jaxatt.studies.stored import open_study

COUNT = 20


def slew(**changes):
    settings = {"horizon.intervals": 20, "windows": None, "solver.starts": 2}
    return scenarios.replace(scenarios.load("hypso1-90-45-15"), settings | changes)


def invoke(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(study_module, "CHUNK", 8)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_module, "CHUNK", 8)
        return attitude_map(slew(), COUNT, tmp_path_factory.mktemp("map") / "whole.zarr")


def test_every_target_is_reached_and_labelled(whole):
    data = whole.dataset
    assert whole.complete
    assert whole.reached
    assert data.sizes["sample"] == COUNT
    q, axis = data["q_ob"].values, data["turn_axis"].values
    half = np.radians(data["turn_deg"].values) / 2.0
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-12)
    first = slew().initial.q_ob
    np.testing.assert_allclose(np.abs(q @ first), np.cos(half), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1.0, atol=1e-12)
    assert (data["active_intervals"] == 2).all()
    assert (data["flight_error_deg"] < 1e-3).all()


def test_a_map_that_was_stopped_goes_on_and_ends_with_the_same_values(whole, tmp_path, monkeypatch):
    path = tmp_path / "stopped.zarr"
    solved = run_module.solve_targets
    calls = []

    def stop_at_the_second(*arguments):
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return solved(*arguments)

    monkeypatch.setattr(run_module, "solve_targets", stop_at_the_second)
    with pytest.raises(KeyboardInterrupt):
        attitude_map(slew(), COUNT, path)
    assert open_study(path).dataset["done"].values.sum() == 8
    monkeypatch.setattr(run_module, "solve_targets", solved)
    again = attitude_map(slew(), COUNT, path)
    xarray.testing.assert_identical(again.dataset, whole.dataset)


def test_merged_tasks_are_the_whole_map(whole, tmp_path):
    parts = [tmp_path / f"{task}.zarr" for task in range(2)]
    for task, path in enumerate(parts):
        attitude_map(slew(), COUNT, path, share=(task, 2))
    assert invoke("merge", *parts, "--out", tmp_path / "all.zarr").exit_code == 0
    xarray.testing.assert_identical(open_study(tmp_path / "all.zarr").dataset, whole.dataset)


def test_a_store_of_another_map_is_refused(whole):
    with pytest.raises(OutputError, match="samples of other values"):
        attitude_map(slew(**{"vehicle.wheels.torque_limit_Nm": 2e-3}), COUNT, whole.path)


def test_one_by_one_where_the_family_has_no_batch(tmp_path):
    found = attitude_map(slew(**{"objective.kind": "l1"}), 2, tmp_path / "l1.zarr")
    assert found.reached
    assert np.isfinite(found.dataset["l1_effort_Nms"]).all()


@pytest.mark.parametrize("name", ["hypso2-orbit", "van-der-pol", "hypso1-path-two"])
def test_what_has_no_one_target_is_refused(name):
    with pytest.raises(ScenarioError, match="one"):
        map_targets(scenarios.load(name), 5)


@pytest.mark.parametrize("count", ["0", "-3", str(10**9)])
def test_absurd_counts_end_in_a_sentence(count, tmp_path):
    found = invoke("map", "hypso1-90-45-15", "--targets", count, "--out", tmp_path / "out")
    assert found.exit_code == 2
    assert "targets" in found.output
    assert not (tmp_path / "out").exists()


def test_the_command_says_and_draws_what_is_not_reached(tmp_path):
    file = tmp_path / "weak.toml"
    file.write_text(
        scenarios.text("hypso1-90-45-15")
        .replace("horizon_s = 70.0", "horizon_s = 28.0")
        .replace("intervals = 50", "intervals = 20")
        .replace('use = "hypso1"', 'use = "hypso1"\nwheels.torque_limit_Nm = 7e-4')
        .split("[[windows]]")[0]
    )
    found = invoke("map", file, "--targets", 12, "--starts", 1, "--out", tmp_path / "out")
    assert found.exit_code == 3, found.output
    assert "not reached" in found.output
    numbers = json.loads((tmp_path / "out/map.json").read_text())
    assert 0 < numbers["reached"] < numbers["targets"] == 12
    assert math.isfinite(numbers["worst_flight_error_deg"])
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"map.json", "map-active_intervals.png", "map-l1_effort_Nms.png"} < names
    shown = invoke("show", *(p for p in (tmp_path / "out").glob("*.zarr")))
    assert "12 of 12 targets done" in " ".join(shown.output.split())
