"""The study of turns in free time still says what it should."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from notebook_runs import complaints, outputs, printed, run_notebook

pytestmark = pytest.mark.slow

PROBE = """
import json
print(json.dumps({
    "rows": comparison.to_dict()["rows"],
    "swept": [[k, rho, r.summary()] for (k, rho), r in swept.items()],
    "saturated": bool(always_saturated.all()),
    "calm": [float(np.abs(calm).max()), straight],
    "half_turn": half_turn.summary(),
}))
"""

IPOPT = {
    (3, 0.01): 28.652703,
    (4, 0.01): 24.194868,
    (5, 0.01): 21.420208,
    (4, 0.1): 24.560578,
    (4, 10.0): 49.459783,
    (5, 10.0): 46.673247,
}
"""(wheels, rho) -> final time [s], by `python -m benchmarks.casadi_reorientation`."""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("notebook")
    return run_notebook("time_and_effort", folder, PROBE, optimised=False)


@pytest.fixture(scope="module")
def numbers(notebook: Any) -> Any:
    return printed(notebook)


def test_timed_study_shows_seven_figures(notebook: Any) -> None:
    assert len(outputs(notebook, "image/png")) == 7
    assert not complaints(notebook)


def test_the_printed_time_belongs_to_half_the_stated_angle(numbers: Any) -> None:
    time = {(round(r["angle_rad"], 2), r["integration"]): r for r in numbers["rows"]}
    assert time[1.25, "euler"]["final_time_s"] == pytest.approx(24.2124, abs=5e-4)
    assert time[2.5, "euler"]["final_time_s"] > 30.0
    assert time[1.25, "rk4"]["attitude_error_deg"] < 1e-3
    assert time[1.25, "euler"]["attitude_error_deg"] > 0.05


def test_time_falls_with_the_wheels_and_effort_rises_where_time_matters(numbers: Any) -> None:
    found = {(k, rho): summary for k, rho, summary in numbers["swept"]}
    assert all(summary["status"] == "reached" for summary in found.values())
    for rho in {rho for _, rho in found}:
        times = [found[k, rho]["final_time_s"] for k in (3, 4, 5)]
        assert times == sorted(times, reverse=True), rho
        if rho <= 0.01:
            efforts = [found[k, rho]["control_effort"] for k in (3, 4, 5)]
            assert efforts == sorted(efforts) and max(times) < 30.0, rho
    for k in (3, 4, 5):
        along = [found[k, rho]["control_effort"] for rho in sorted({rho for _, rho in found})]
        # Three wheels spend the same for 0.001 and 0.01, to the solver's tolerance.
        assert all(after <= before + 1e-4 for before, after in itertools.pairwise(along)), k


def test_final_times_are_those_of_ipopt(numbers: Any) -> None:
    found = {(k, rho): summary["final_time_s"] for k, rho, summary in numbers["swept"]}
    for case, time in IPOPT.items():
        assert found[case] == pytest.approx(time, abs=2e-5), case


def test_torques_saturate_where_time_matters_and_not_where_effort_does(numbers: Any) -> None:
    assert numbers["saturated"]
    largest, straight = numbers["calm"]
    assert largest < 0.5
    # The wheels that do most of the work; the first two hardly turn.
    assert min(straight[2:]) > 0.9
    assert numbers["half_turn"]["final_time_s"] <= 3.2436
