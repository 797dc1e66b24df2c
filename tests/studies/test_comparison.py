"""The table of controllers: the PD baseline flown, the optimised rows beside the printed values."""

import json

import handmade_results
import pytest

import jaxatt.studies.comparison
from jaxatt import scenarios
from jaxatt.studies.baseline import fly_pd_phases
from jaxatt.studies.compare import compare


@pytest.fixture
def solved(monkeypatch):
    """Answers made by hand in the place of solves; the objectives asked for, in order."""
    asked = []

    def solve(scenario, objective, report, **_):
        asked.append(objective)
        if report is not None:
            report("polishing", 1)
        return handmade_results.handmade(scenario.name)

    monkeypatch.setattr(jaxatt.studies.comparison, "solve", solve)
    return asked


def test_rows_stand_beside_the_printed_values(solved):
    stages = []
    found = compare("hypso1-90-45-15", report=lambda stage, done: stages.append(stage))
    assert solved == ["l1", "l0", "moving-l0"]
    assert stages == ["polishing (L1)", "polishing (L0)", "polishing (Moving L0)"]
    rows = {row.controller: row for row in found.rows}
    assert list(rows) == ["PD, clipped", "PD, unclipped", "L1", "L0", "Moving L0"]
    assert rows["Moving L0"].printed.active_outside_windows == 1
    assert rows["L0"].printed.cpu_time_s == pytest.approx(66.216)
    assert rows["L0"].active_outside_windows == 2
    assert rows["L0"].weighted_active_intervals == pytest.approx(2.001)
    assert rows["PD, clipped"].reached
    assert rows["PD, clipped"].active_intervals > rows["PD, unclipped"].active_intervals > 2
    assert rows["PD, clipped"].attitude_error_deg < 0.01
    text = str(found)
    assert "3 (2)" in text and "attitude [deg]" in text
    assert "Moving L0" in found._repr_html_()


def test_a_toy_knows_neither_pd_nor_windows(solved, tmp_path):
    found = compare("double-integrator")
    assert solved == ["l1", "l0"]
    assert [row.controller for row in found.rows] == ["L1", "L0"]
    assert "state error" in str(found)
    found.save(tmp_path / "out")
    written = json.loads((tmp_path / "out/comparison.json").read_text())
    assert [row["controller"] for row in written["rows"]] == ["L1", "L0"]
    assert (tmp_path / "out/l0/summary.json").is_file()
    assert (tmp_path / "out/comparison.png").is_file()


def test_the_pd_law_starts_a_leg_where_the_last_one_ended():
    first, second = fly_pd_phases(scenarios.load("hypso1-path-two"))
    assert first.reached and second.reached
    assert second.l1_effort == pytest.approx(first.l1_effort, rel=0.05)
    assert second.active.any()
