"""Sweeps that are run, killed, shared out and merged: the values are always the same."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

import jaxatt
from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.runtime.files import OutputError
from jaxatt.scenarios import ScenarioError
from jaxatt.studies.stored import open_study
from jaxatt.studies.sweep import run as run_module
from jaxatt.studies.sweep.reading import read_study
from jaxatt.studies.sweep.run import run_study
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED
from jaxatt.studies.sweep.sweep import sweep

TOY = """
scenario = "double-integrator"
outputs = ["active_intervals", "l1_effort_Nms", "objective.total", "starts.reached_target"]
chunk = 2

[fixed]
solver.starts = 3
horizon.intervals = 24

[[vary]]
field = "control.limit"
values = [1.0, -1.0, 0.1, 0.9]

[[vary]]
field = "initial.state.0"
from = 0.3
to = 0.9
count = 3
"""
LIMITS = np.repeat([1.0, -1.0, 0.1, 0.9], 3)


def invoke(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def plain(found) -> str:
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", found.output).split())


def files(store: Path) -> dict[str, bytes]:
    """Contents of all files of a store, save what a killed process left."""
    return {
        str(file.relative_to(store)): file.read_bytes()
        for file in sorted(store.rglob("*"))
        if file.is_file() and file.suffix != ".partial"
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """Folder of the study, and of the store and figure of one run to the end."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "toy.toml").write_text(TOY)
    found = invoke("sweep", folder / "toy.toml", "--out", folder / "out")
    assert found.exit_code == 3, found.output
    assert "12 of 12 samples done, 6 reached" in plain(found)
    assert "3 samples do not reach their target, 3 have no answer" in plain(found)
    assert "must be" in plain(found)  # why
    return folder


def test_every_sample_keeps_its_values_or_its_reason(whole: Path) -> None:
    data = xarray.open_zarr(whole / "out/toy.zarr", chunks=None).load()
    np.testing.assert_array_equal(data["limit"], LIMITS)
    expected = np.select([LIMITS < 0.0, LIMITS < 0.5], [FAILED, NOT_REACHED], REACHED)
    np.testing.assert_array_equal(data.state, expected)
    np.testing.assert_array_equal(data.reason.values.astype(bool), expected != REACHED)
    assert np.isnan(data.active_intervals[LIMITS < 0.0]).all()
    assert data.done.all() and "limit" in data.coords
    one = 11
    case = scenarios.replace(
        scenarios.load("double-integrator"),
        {
            "solver.starts": 3,
            "horizon.intervals": 24,
            "control.limit": float(data["limit"][one]),
            "initial.state": [float(data.state_0[one]), 1.0],
        },
    )
    told = jaxatt.solve(case).summary()
    assert data.active_intervals[one] == told["active_intervals"]
    assert data["objective.total"][one] == told["objective"]["total"]
    assert data["starts.reached_target"][one] == told["starts"]["reached_target"]


def test_a_grid_has_a_dimension_for_each_quantity(whole: Path) -> None:
    found = open_study(whole / "out/toy.zarr")
    grid = found.grid()
    assert grid.sizes == {"limit": 4, "state_0": 3}
    for limit in (0.9, 1.0):
        picked = grid.sel(limit=limit).active_intervals
        flat = found.dataset.active_intervals.values[limit == LIMITS]
        np.testing.assert_array_equal(picked, flat)
    assert json.loads(found.dataset.attrs["study_document"])["scenario"] == "double-integrator"
    assert repr(found).endswith("12 of 12 samples, 6 reached)") and "active_intervals" in str(found)


def test_other_values_compile_nothing(whole: Path, tmp_path: Path, compilations) -> None:
    study = {"scenario": "double-integrator", "outputs": ["active_intervals"]}
    study["fixed"] = {"solver.starts": 3, "horizon.intervals": 24}
    rng = np.random.default_rng(1129)
    limits = rng.uniform(0.8, 1.2, 3).tolist()
    study["vary"] = [{"field": "control.limit", "values": limits}]
    found = sweep(study, tmp_path / "a.zarr")
    assert found.reached and found.complete
    assert not compilations
    figure = found.plot()
    assert [axes.get_xlabel() for axes in figure.axes] == ["limit"]


def test_tasks_merged_are_the_single_run(whole: Path, tmp_path: Path) -> None:
    for task in ("0/2", "1/2"):
        found = invoke("sweep", whole / "toy.toml", "--task", task, "--out", tmp_path)
        assert found.exit_code == 3 and "jaxatt merge joins" in found.output
    tasks = [tmp_path / f"toy.task-{k}-of-2.zarr" for k in (0, 1)]
    assert not any(open_study(task).complete for task in tasks)
    found = invoke("merge", *tasks, "--out", tmp_path / "toy.zarr")
    assert found.exit_code == 0 and "12 of 12 samples" in found.output
    assert files(tmp_path / "toy.zarr") == files(whole / "out/toy.zarr")
    found = invoke("show", tmp_path / "toy.zarr")
    assert found.exit_code == 0 and "12 of 12 samples done" in found.output
    assert (tmp_path / "sweep.png").is_file()


def test_a_growing_store_is_shown_and_continued(whole: Path, tmp_path: Path, monkeypatch) -> None:
    solve_many, done = run_module.solve_many, []

    def interrupted(documents, base):
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(documents)
        return solve_many(documents, base)

    monkeypatch.setattr(run_module, "solve_many", interrupted)
    found = invoke("sweep", whole / "toy.toml", "--out", tmp_path)
    assert found.exit_code == 130 and "goes on from it" in plain(found)
    growing = open_study(tmp_path / "toy.zarr")
    assert growing.dataset.done.sum() == 6 and not growing.complete
    shown = invoke("show", tmp_path / "toy.zarr", "--quiet")
    assert "6 of 12 samples" in shown.output
    monkeypatch.undo()
    assert invoke("sweep", whole / "toy.toml", "--out", tmp_path).exit_code == 3
    assert files(tmp_path / "toy.zarr") == files(whole / "out/toy.zarr")


def test_more_samples_than_a_map_are_drawn_as_points(tmp_path: Path) -> None:
    study = {
        "scenario": "double-integrator",
        "outputs": ["active_intervals", "cost"],
        "fixed": {"solver.starts": 3, "horizon.intervals": 24},
        "sampling": {"method": "sobol", "samples": 4, "seed": random.randrange(100)},
        "vary": [
            {"field": "initial.state.0", "from": 0.3, "to": 0.9},
            {"field": "control.limit", "from": -1.0, "to": 2.0},
        ],
    }
    found = sweep(study, tmp_path / "a.zarr")
    assert len(found.plot().axes) == 4 and found.failed >= 1
    with pytest.raises(ScenarioError, match="makes no grid"):
        found.grid()


def test_unknown_outputs_are_refused_before_anything_is_written(
    whole: Path, tmp_path: Path
) -> None:
    cases = {
        "active_interval": "did you mean 'active_intervals'",
        "objective": "objective.total",
        "active_interval_indices": "holds several values",
        "device": "is a text",
    }
    for name, words in cases.items():
        (tmp_path / "s.toml").write_text(TOY.replace('"l1_effort_Nms"', f'"{name}"'))
        found = invoke("sweep", tmp_path / "s.toml", "--out", tmp_path / "out")
        assert found.exit_code == 2 and words in plain(found), found.output
        assert name in plain(found) and not (tmp_path / "out").exists()


def test_bad_input_ends_with_a_sentence(whole: Path, tmp_path: Path) -> None:
    study, out = whole / "toy.toml", whole / "out"
    (tmp_path / "other.toml").write_text(TOY.replace("0.9]", "0.8]"))
    (tmp_path / "none.toml").write_text(TOY.replace("[1.0, -1.0, 0.1, 0.9]", "[-1.0, -2.0]"))
    cases = [
        (("sweep", study, "--task", "2/2"), "--task 2/2: is no task"),
        (("sweep", study, "--task", "two"), "--task two: is no task"),
        (("sweep", "mrp-k3"), "mrp-k3: varies nothing; write a study with scenario"),
        (("sweep", "torque-and-horizo"), "did you mean"),
        (("sweep", study, "--starts", 4, "--out", out), "holds samples of other values"),
        (("sweep", tmp_path / "none.toml", "--out", tmp_path), "none of 6 samples"),
        (("show", tmp_path), "is no store"),
        (("show", tmp_path / "nowhere.zarr"), "no such store"),
        (("merge", out / "toy.zarr", "--out", out / "toy.zarr"), "is merged itself"),
    ]
    for arguments, words in cases:
        found = invoke(*arguments)
        assert found.exit_code == 2 and words in plain(found), (arguments, found.output)
    with pytest.raises(OutputError, match="holds samples of other values"):
        document = {**scenarios_document(), "name": "toy"}
        run_study(read_study(document), out / "toy.zarr")


def scenarios_document() -> dict:
    return {
        "scenario": "double-integrator",
        "outputs": ["cost"],
        "vary": [{"field": "control.limit", "values": [1.0]}],
    }


def killed(study: Path, out: Path, when: float | int) -> bool:
    """Start a sweep and kill it after a time [s], or once a number of chunks is there."""
    command = [sys.executable, "-m", "jaxatt", "sweep", str(study), "--out", str(out), "--quiet"]
    environment = {**os.environ, "PYTHONPATH": str(Path(jaxatt.__file__).parents[1])}
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    began = time.monotonic()
    while process.poll() is None:
        chunks = len(list(out.glob("*.zarr/done/c/*")))
        if (time.monotonic() - began > when) if isinstance(when, float) else chunks >= when:
            process.send_signal(signal.SIGKILL)
            break
        time.sleep(0.002)
    _, complaint = process.communicate()
    assert process.returncode in (-signal.SIGKILL, 3), complaint.decode()
    return process.returncode == -signal.SIGKILL


def test_killed_twice_it_ends_with_the_same_store(whole: Path, tmp_path: Path) -> None:
    first = random.randint(1, 2)
    assert killed(whole / "toy.toml", tmp_path, first)
    assert killed(whole / "toy.toml", tmp_path, first + random.randint(1, 2))
    assert invoke("sweep", whole / "toy.toml", "--out", tmp_path).exit_code == 3
    assert files(tmp_path / "toy.zarr") == files(whole / "out/toy.zarr")


@pytest.mark.slow
@pytest.mark.optimised
def test_killed_at_random_moments_it_ends_with_the_same_store(tmp_path: Path) -> None:
    many = TOY.replace("count = 3", "count = 40").replace("chunk = 2", "chunk = 1")
    (tmp_path / "toy.toml").write_text(many)
    assert invoke("sweep", tmp_path / "toy.toml", "--out", tmp_path / "whole").exit_code == 3
    kills = sum(
        killed(tmp_path / "toy.toml", tmp_path / "out", random.uniform(2.0, 12.0)) for _ in range(5)
    )
    kills_while_writing = len(list((tmp_path / "out/toy.zarr").rglob("*.partial")))
    print(f"{kills} kills, {kills_while_writing} files half-written at the last")
    assert kills >= 2
    assert invoke("sweep", tmp_path / "toy.toml", "--out", tmp_path / "out").exit_code == 3
    assert files(tmp_path / "out/toy.zarr") == files(tmp_path / "whole/toy.zarr")
