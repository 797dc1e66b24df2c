"""The study of on-off thrusters still says what it should."""

from __future__ import annotations

from typing import Any

import pytest
from notebook_runs import complaints, outputs, printed, run_notebook

pytestmark = [pytest.mark.slow, pytest.mark.optimised]

PROBE = """
import json
from dataclasses import asdict
print(json.dumps({
    "results": {name: result.summary() for name, result in results.items()},
    "findings": {name: asdict(finding) for name, finding in findings.items()},
    "penalty": penalty,
    "shortest": float(widths.min()),
    "slow": slow.summary()["quantised"],
    "study": study.to_dict(),
}))
"""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook("on_off_thrusters", tmp_path_factory.mktemp("notebook"), PROBE)


@pytest.fixture(scope="module")
def numbers(notebook: Any) -> Any:
    return printed(notebook)


def test_thruster_study_shows_nine_figures_and_more(notebook: Any) -> None:
    assert len(outputs(notebook, "image/png")) >= 11
    assert not complaints(notebook)


@pytest.mark.parametrize(("name", "most"), [("eseo-1", 10), ("eseo-2", 20), ("eseo-3", 10)])
def test_thrusters_reach_relaxed_and_quantised(numbers: Any, name: str, most: int) -> None:
    answer = numbers["results"][name]
    for block in (answer, answer["quantised"]):
        assert block["status"] == "reached"
        assert block["active_intervals"] <= most
        assert block["attitude_error_deg"] < 0.05 and block["rate_error_rad_s"] < 1e-4
    assert answer["quantised"]["partially_open_samples"] == 0
    assert answer["quantised"]["opposed_firings"] == 0
    whole = answer["quantised_otherwise"]
    assert whole["mode"] == "interval" and whole["partially_open_samples"] == 0
    assert whole["active_intervals"] <= answer["active_intervals"]


def test_printed_relative_sparsity_is_judged(numbers: Any) -> None:
    found = numbers["findings"]
    assert found["eseo-1"]["reached"]
    assert not found["eseo-2"]["reached"] and found["eseo-2"]["attitude_error_deg"] > 1.0
    assert not found["eseo-3"]["reached"] and found["eseo-3"]["attitude_error_deg"] > 1.0


@pytest.mark.parametrize(
    ("name", "best"), [("eseo-1", 1759.7), ("eseo-2", 3094.1), ("eseo-3", 3920.1)]
)
def test_printed_weights_prefer_not_to_brake(numbers: Any, name: str, best: float) -> None:
    answer = numbers["penalty"][name]
    assert answer["objective"]["total"] <= best
    assert answer["status"] == "not reached" and answer["alternative"]["status"] == "reached"
    assert answer["alternative"]["objective"]["total"] > best


def test_valves_keep_their_shortest_opening(numbers: Any) -> None:
    assert numbers["shortest"] >= 0.05 - 1e-9
    assert numbers["slow"]["status"] == "reached"


def test_no_slew_beats_the_impulse_balance(numbers: Any) -> None:
    study = numbers["study"]
    for point in (*study["against_intervals"], *study["against_limit"]):
        assert point["reached"]
        assert point["bound_percent"] <= point["percent"]
        assert point["bound_percent"] < point["eigenaxis_percent"]
    percents = [point["percent"] for point in study["against_limit"]]
    assert percents == sorted(percents, reverse=True)
