"""The printed tables of the closed-loop sources, by the bundled flights."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from jaxatt import compare_flight, simulate
from jaxatt.cli import app
from jaxatt.control.eigenaxis import Eigenaxis
from jaxatt.report.archive import open_archive
from jaxatt.scenarios import load_flight, replace_in_flight
from jaxatt.studies.imaging import compare_imaging


def lines_of(comparison):
    return {(line.law, line.figure): line for line in comparison.lines}


def test_large_slew_gives_table_one_but_its_settling_times(tmp_path):
    comparison = compare_flight("microsatellite-large-slew")
    lines = lines_of(comparison)
    for law in ("gain-scheduled min-norm", "Krstic-Tsiotras"):
        assert lines[law, "peak_Nm"].worst < 0.01, law
        assert lines[law, "integral_Nms"].worst < 0.01, law
        settling = lines[law, "settling_s"]
        assert not settling.reproduced and "none of the twelve" in settling.why
    assert "NOT" in str(comparison)
    files = comparison.save(tmp_path / "large")
    assert all(file.is_file() for file in files)
    saved = json.loads((tmp_path / "large/comparison.json").read_text())
    assert {line["figure"] for line in saved["lines"]} >= {"peak_Nm", "integral_Nms", "settling_s"}


def test_pointing_settles_as_printed():
    """With the PD law; the others are held by the notebook of feedback laws."""
    # The first 80 s are enough to settle.
    flight = replace_in_flight(load_flight("hypso1-pointing"), {"simulation.duration_s": 80.0})
    settling = np.asarray(simulate(flight, "pd").flown.figures.settling)[0, :3]
    np.testing.assert_allclose(settling, (21.0, 20.0, 18.4), rtol=0.05)


@pytest.mark.slow
@pytest.mark.optimised
def test_slewing_settles_as_printed_where_the_attitude_is_free():
    flight = replace_in_flight(load_flight("hypso1-slewing"), {"simulation.duration_s": 80.0})
    figures = simulate(flight, "gsta").flown.figures
    assert np.asarray(figures.always_inside)[0, [0, 2]].all()
    assert np.asarray(figures.settling)[0, 1] == pytest.approx(3.63, rel=0.05)


@pytest.mark.parametrize(
    ("gamma", "limit"),
    [(0.010, 113.05), (0.015, 89.13), (0.020, 84.03), (0.025, 87.08), (0.030, 93.46)],
)
def test_settling_limits(gamma, limit):
    low = Eigenaxis(0.002, 0.05)
    assert low.settling_limit(gamma) == pytest.approx(limit, abs=5e-3)
    assert low.settling_limit(low.fastest()) <= low.settling_limit(gamma)
    assert low.settling_limit(low.gamma_for(limit + 0.01)) == pytest.approx(limit + 0.01, rel=1e-9)
    with pytest.raises(ValueError, match="no gamma settles faster"):
        low.gamma_for(80.0)


def test_ground_sampling_distance():
    found = compare_imaging()
    rows = {row.altitude_km: row for row in found.rows}
    assert rows[500.0].frame_rate == pytest.approx(22.0, abs=0.3)
    assert rows[500.0].slew_m == pytest.approx(139.0, rel=0.01)
    assert found.fitted.altitude_km == pytest.approx(554.0, abs=3.0)
    assert found.fitted.slew_m == pytest.approx(117.0, abs=0.1)
    assert found.fitted.nadir_m == pytest.approx(321.6, abs=0.1)
    assert "554 km only" in str(found)


def test_the_command_line_simulates(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    shown = runner.invoke(app, ["scenarios", "show", "microsatellite-large-slew"])
    (tmp_path / "mine.toml").write_text(
        shown.output.replace('"microsatellite-large-slew"', '"mine"', 1).replace(
            "tumbling_rad_s = 100.0", "tumbling_rad_s = 0.5"
        )
    )
    found = runner.invoke(app, ["simulate", "mine.toml", "--runs", "20", "--seed", "3"])
    assert found.exit_code == 3, found.output  # runs turn faster than 0.5 rad/s: failed
    assert "diverged" in found.output
    folder = tmp_path / "results/mine"
    assert {f.name for f in folder.iterdir()} == {
        "summary.json",
        "flight.nc",
        "overview.png",
        "phase_portrait.png",
    }
    summary = json.loads((folder / "summary.json").read_text())
    failed = sum(block["count"] for block in summary["failed"].values())
    assert summary["runs"] == 20 and failed > 0
    assert summary["integral_Nms"]["count"] == 20 - failed
    archive = open_archive(folder / "flight.nc")
    assert archive.sizes["run"] == 20 and archive.wheel_torque.attrs["units"] == "N m"
    assert int((archive.ending != 0).sum()) == failed
    wrong = runner.invoke(app, ["simulate", "mine.toml", "--law", "lqr"])
    assert wrong.exit_code == 2 and "there is no such law" in wrong.output
    assert math.isfinite(summary["time_s"]["simulate"])
