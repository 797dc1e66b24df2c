"""The ESEO slew from scenario to summary, at 45 intervals; the notebook runs the others."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jaxatt
from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.report.result import Result


@pytest.fixture(scope="module")
def solved() -> Result:
    return jaxatt.solve("eseo-3", starts=4)


def test_summary_has_the_quantised_block(solved: Result, tmp_path: Path) -> None:
    solved.save(tmp_path)
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert numbers["status"] == "reached" and numbers["active_intervals"] <= 10
    valves = numbers["quantised"]
    assert valves["status"] == "reached" and valves["active_intervals"] <= 10
    assert valves["attitude_error_deg"] < 0.05 and valves["rate_error_rad_s"] < 1e-4
    assert valves["partially_open_samples"] == 0 and valves["opposed_firings"] == 0
    assert len(valves["on_time_s"]) == 6
    assert valves["relative_sparsity_percent"] == pytest.approx(
        100.0 * valves["active_intervals"] / 45
    )
    for name in ("overview", "quaternion", "torque_thrusters", "valves", "omega_ob"):
        assert (tmp_path / f"{name}.png").stat().st_size > 5000
    archive = jaxatt.open_archive(tmp_path / "result.nc")
    width = (archive["quantised_shuts"] - archive["quantised_opens"]).sum("interval")
    np.testing.assert_allclose(width, valves["on_time_s"])


def test_schmitt_baseline_serves_as_a_start(solved: Result) -> None:
    guessed = jaxatt.solve("eseo-3", starts=4, guess="pd")
    assert guessed.reached and guessed.active_intervals <= solved.active_intervals


def test_on_off_term_counts_where_thrusters_fire_and_as_printed_it_does_not() -> None:
    rng = np.random.default_rng(0)
    controls = np.zeros((1, 45, 6))
    controls[0, :5] = rng.uniform(0.0, 0.0975, (5, 6))
    costs = {}
    for form in ("active", "printed"):
        task = build_slew(
            scenarios.replace(scenarios.load("eseo-3"), {"objective.on_off_form": form})
        )
        assert isinstance(task, SlewTask)
        costs[form] = float(task.verify(controls)[1]["on_off"][0])
    expected = 2550.0 * np.sum(controls * (0.0975 - controls))
    assert costs["active"] == pytest.approx(expected, rel=1e-4)
    assert costs["printed"] < 1e-4 * expected


def test_whole_openings_cost_nothing_extra() -> None:
    task = build_slew(scenarios.load("eseo-3"))
    controls = np.zeros((1, 45, 6))
    controls[0, :4, :3] = 0.0975
    assert task.verify(controls)[1]["on_off"][0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["hypso1-90-0-0"], "the study is for vehicles with thrusters"),
        (["eseo-1", "--limits", "1,-1"], "greater than 0"),
        (["eseo-1", "--intervals", "2.5"], "whole numbers"),
        (["eseo-1", "--intervals", "many"], "separated by commas"),
    ],
)
def test_sparsity_refuses_what_it_cannot_study(
    arguments: list[str], words: str, tmp_path: Path
) -> None:
    shown = CliRunner().invoke(app, ["sparsity", *arguments, "--out", str(tmp_path / "out")])
    assert shown.exit_code == 2
    assert words in " ".join(shown.output.replace("│", " ").split())


def test_riccati_steps_are_refused_with_thrusters() -> None:
    with pytest.raises(ValueError, match="thrusters have a method of their own"):
        jaxatt.solve("eseo-3", starts=1, inner="riccati")
