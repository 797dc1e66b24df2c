"""The hands-off study still says what it should."""

from __future__ import annotations

from typing import Any

import pytest
from notebook_runs import complaints, outputs, printed, run_notebook

pytestmark = [pytest.mark.slow, pytest.mark.optimised]

PROBE = """
import json
print(json.dumps({
    "found": found,
    "resting": resting,
    "penalty": {"45": penalty_45.summary(), "90": penalty_90.summary()},
    "designs": {str(n): r.summary() for n, r in designs.items()},
    "costs": {str(n): cost for n, cost in costs.items()},
    "guesses": {label: r.summary() for label, r in guessed.items()},
    "frames": {axes: r.summary() for axes, r in frames.items()},
    "forbidden": {label: r.summary() for label, r in forbidden.items()},
    "toys": {" ".join(key): r.summary() for key, r in toys.items()},
}))
"""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook("maximum_hands_off", tmp_path_factory.mktemp("notebook"), PROBE)


@pytest.fixture(scope="module")
def numbers(notebook: Any) -> Any:
    return printed(notebook)


def test_study_shows_tables_and_figures(notebook: Any) -> None:
    assert len(outputs(notebook, "image/png")) >= 5
    assert len(outputs(notebook, "text/markdown")) >= 15
    assert not complaints(notebook)


def test_every_optimised_case_is_reached_in_flight(numbers: Any) -> None:
    assert len(numbers["found"]) == 21  # seven cases, three controllers
    for case, row in numbers["found"].items():
        assert row["status"] == "reached", case
        assert row["attitude_error_deg"] < 0.01, case
        assert row["rate_error_rad_s"] < 1e-5, case
        assert row["torque_violation_Nm"] <= 1e-9, case


def test_l0_needs_as_many_intervals_as_printed(numbers: Any) -> None:
    rows = {case: row for case, row in numbers["found"].items() if case.endswith(", l0")}
    assert len(rows) == 7
    for case, row in rows.items():
        assert row["active"] == row["printed"], case


def test_moving_l0_stays_inside_its_windows(numbers: Any) -> None:
    for case, row in numbers["found"].items():
        if case.endswith("moving-l0") and not case.startswith("hypso1-path,"):
            assert row["outside"] == 0, case


def test_printed_objective_prefers_not_moving_where_resting_is_cheap(numbers: Any) -> None:
    assert numbers["resting"]["(45, 0, 0)"] == pytest.approx(7.612, abs=2e-3)
    assert numbers["resting"]["(90, 45, 15)"] == pytest.approx(31.699, abs=2e-3)
    assert numbers["resting"]["path by intermediate quaternion"] == pytest.approx(10.231, abs=2e-3)
    resting, moving = numbers["penalty"]["45"], numbers["penalty"]["90"]
    assert resting["status"] == "not reached" and resting["active_intervals"] == 0
    assert resting["alternative"]["status"] == "reached"
    assert moving["status"] == "reached" and moving["objective"]["total"] <= 20.001


def test_designs_guesses_and_axes(numbers: Any) -> None:
    designs = numbers["designs"]
    assert {design["status"] for design in designs.values()} == {"reached"}
    assert designs["1"]["active_intervals"] == 2
    # (5.14a) and (5.15) differ by 2 N k3 = 1000 and by nothing else.
    costs = numbers["costs"]
    assert costs["2"] - costs["3"] == pytest.approx(1000.0, abs=1e-3)
    # Six pairs of an interval and an axis cost 60, which is what design 1's pulses would.
    assert costs["2"] < 60.0
    for label, answer in (numbers["guesses"] | numbers["frames"]).items():
        if label == "all ones, the full limit" and answer["status"] != "reached":
            assert answer["obstacle"], "a guess that leads nowhere must say why"
            continue
        assert answer["status"] == "reached", label
        assert answer["active_intervals"] == 2, label


def test_forbidden_windows_hold(numbers: Any) -> None:
    inside = numbers["forbidden"]["only 20 to 30 allowed"]
    quiet = numbers["forbidden"]["quiet until 14 s"]
    assert inside["status"] == quiet["status"] == "reached"
    assert all(20 <= k <= 30 for k in inside["active_interval_indices"])
    assert min(quiet["active_interval_indices"]) >= 10
    assert quiet["active_intervals"] == 2


def test_toys_match_what_is_known(numbers: Any) -> None:
    toys = numbers["toys"]
    assert {toy["status"] for toy in toys.values()} == {"reached"}
    exact = 5.0 - 10.0**0.5
    assert toys["double-integrator l1"]["l1_effort_Nms"] == pytest.approx(exact, rel=1e-3)
    assert 0.05 * toys["double-integrator l0"]["active_intervals"] == pytest.approx(exact, rel=0.05)
