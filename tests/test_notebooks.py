"""Every notebook runs from top to bottom, and the study still says what it should."""

from __future__ import annotations

import itertools
import json
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
STUDY = NOTEBOOKS / "maximum_hands_off.py"
FEEDBACK = NOTEBOOKS / "feedback_laws.py"
THRUSTERS = NOTEBOOKS / "on_off_thrusters.py"
TIMED = NOTEBOOKS / "time_and_effort.py"
CELL_TIMEOUT_S = 600

# Read back from the notebook's own variables, in a last cell that only the test adds.
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


def run_notebook(script: Path, folder: Path, probe: str = "") -> Any:
    """Run a percent script in a fresh kernel of this very Python; return the executed notebook.

    Raises `nbclient.exceptions.CellExecutionError` where a cell fails.
    """
    with warnings.catch_warnings():
        # Jupyter announces where it will look for its own files.
        warnings.filterwarnings("ignore", "Jupyter is migrating", DeprecationWarning)
        import jupytext
        import nbformat
        from jupyter_client.kernelspec import KernelSpecManager
        from jupyter_client.manager import AsyncKernelManager
        from nbclient import NotebookClient

        # A kernel of its own name: a "python3" installed by the user might be another Python.
        kernel = folder / "kernels" / "this-python"
        kernel.mkdir(parents=True)
        specification = {
            "argv": [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"],
            "display_name": "this Python",
            "language": "python",
            "env": {"MPLBACKEND": "agg"},
        }
        (kernel / "kernel.json").write_text(json.dumps(specification), encoding="utf-8")
        known = KernelSpecManager(kernel_dirs=[str(folder / "kernels")])
        notebook = jupytext.read(script)
        if probe:
            notebook.cells.append(nbformat.v4.new_code_cell(probe))
        return NotebookClient(
            notebook,
            km=AsyncKernelManager(kernel_name="this-python", kernel_spec_manager=known),
            timeout=CELL_TIMEOUT_S,
            resources={"metadata": {"path": str(folder)}},
        ).execute()


def outputs(notebook: Any, kind: str) -> list[str]:
    """All outputs of a MIME type."""
    return [
        output["data"][kind]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if kind in output.get("data", {})
    ]


def test_every_notebook_is_run_here() -> None:
    assert sorted(NOTEBOOKS.glob("*.py")) == [FEEDBACK, STUDY, THRUSTERS, TIMED]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook(STUDY, tmp_path_factory.mktemp("study"), PROBE)


@pytest.fixture(scope="module")
def numbers(study: Any) -> Any:
    return json.loads(study.cells[-1]["outputs"][0]["text"])


@pytest.mark.slow
def test_study_shows_tables_and_figures(study: Any) -> None:
    assert len(outputs(study, "image/png")) >= 5
    assert len(outputs(study, "text/markdown")) >= 15
    assert not [o for c in study.cells for o in c.get("outputs", []) if o.get("name") == "stderr"]


@pytest.mark.slow
def test_every_optimised_case_is_reached_in_flight(numbers: Any) -> None:
    assert len(numbers["found"]) == 21  # seven cases, three controllers
    for case, row in numbers["found"].items():
        assert row["status"] == "reached", case
        assert row["attitude_error_deg"] < 0.01, case
        assert row["rate_error_rad_s"] < 1e-5, case
        assert row["torque_violation_Nm"] <= 1e-9, case


@pytest.mark.slow
def test_l0_needs_as_many_intervals_as_printed(numbers: Any) -> None:
    rows = {case: row for case, row in numbers["found"].items() if case.endswith(", l0")}
    assert len(rows) == 7
    for case, row in rows.items():
        assert row["active"] == row["printed"], case


@pytest.mark.slow
def test_moving_l0_stays_inside_its_windows(numbers: Any) -> None:
    for case, row in numbers["found"].items():
        if case.endswith("moving-l0") and not case.startswith("hypso1-path,"):
            assert row["outside"] == 0, case


@pytest.mark.slow
def test_printed_objective_prefers_not_moving_where_resting_is_cheap(numbers: Any) -> None:
    assert numbers["resting"]["(45, 0, 0)"] == pytest.approx(7.612, abs=2e-3)
    assert numbers["resting"]["(90, 45, 15)"] == pytest.approx(31.699, abs=2e-3)
    assert numbers["resting"]["path by intermediate quaternion"] == pytest.approx(10.231, abs=2e-3)
    resting, moving = numbers["penalty"]["45"], numbers["penalty"]["90"]
    assert resting["status"] == "not reached" and resting["active_intervals"] == 0
    assert resting["alternative"]["status"] == "reached"
    assert moving["status"] == "reached" and moving["objective"]["total"] <= 20.001


@pytest.mark.slow
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


@pytest.mark.slow
def test_forbidden_windows_hold(numbers: Any) -> None:
    inside = numbers["forbidden"]["only 20 to 30 allowed"]
    quiet = numbers["forbidden"]["quiet until 14 s"]
    assert inside["status"] == quiet["status"] == "reached"
    assert all(20 <= k <= 30 for k in inside["active_interval_indices"])
    assert min(quiet["active_interval_indices"]) >= 10
    assert quiet["active_intervals"] == 2


@pytest.mark.slow
def test_toys_match_what_is_known(numbers: Any) -> None:
    toys = numbers["toys"]
    assert {toy["status"] for toy in toys.values()} == {"reached"}
    exact = 5.0 - 10.0**0.5
    assert toys["double-integrator l1"]["l1_effort_Nms"] == pytest.approx(exact, rel=1e-3)
    assert 0.05 * toys["double-integrator l0"]["active_intervals"] == pytest.approx(exact, rel=0.05)


FEEDBACK_PROBE = """
import json
print(json.dumps({
    "lines": [
        [c.scenario.name, line.law, line.figure, line.worst]
        for c in (pointing, slewing, table_f2, table_1) for line in c.lines
    ],
    "tuned": [float(printed.settling[printed.chosen]), tuned.values["settling"]],
    "campaign": campaign.summary()["settled"],
    "gsd": imaging.fitted.altitude_km,
}))
"""


THRUSTER_PROBE = """
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


@pytest.mark.slow
def test_feedback_laws(tmp_path: Path) -> None:
    notebook = run_notebook(FEEDBACK, tmp_path, FEEDBACK_PROBE)
    assert len(outputs(notebook, "image/png")) >= 13
    assert not [
        o for c in notebook.cells for o in c.get("outputs", []) if o.get("name") == "stderr"
    ]
    numbers = json.loads(notebook.cells[-1]["outputs"][0]["text"])
    worst = {tuple(line[:3]): line[3] for line in numbers["lines"]}
    for law in ("PD", "GSTA", "SMC"):
        assert worst["hypso1-pointing", law, "settling_s"] < 0.05, law
    for law in ("gain-scheduled min-norm", "Krstic-Tsiotras"):
        assert worst["microsatellite-large-slew", law, "peak_Nm"] < 0.01, law
    printed, tuned = numbers["tuned"]
    assert tuned < printed - 1.0
    assert numbers["campaign"] >= 195
    assert numbers["gsd"] == pytest.approx(554.0, abs=3.0)


@pytest.fixture(scope="module")
def thrusters(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook(THRUSTERS, tmp_path_factory.mktemp("thrusters"), THRUSTER_PROBE)


@pytest.fixture(scope="module")
def thruster_numbers(thrusters: Any) -> Any:
    return json.loads(thrusters.cells[-1]["outputs"][0]["text"])


@pytest.mark.slow
def test_thruster_study_shows_nine_figures_and_more(thrusters: Any) -> None:
    assert len(outputs(thrusters, "image/png")) >= 11
    errors = [o for c in thrusters.cells for o in c.get("outputs", []) if o.get("name") == "stderr"]
    assert not errors


@pytest.mark.slow
@pytest.mark.parametrize(("name", "most"), [("eseo-1", 10), ("eseo-2", 20), ("eseo-3", 10)])
def test_thrusters_reach_relaxed_and_quantised(thruster_numbers: Any, name: str, most: int) -> None:
    answer = thruster_numbers["results"][name]
    for block in (answer, answer["quantised"]):
        assert block["status"] == "reached"
        assert block["active_intervals"] <= most
        assert block["attitude_error_deg"] < 0.05 and block["rate_error_rad_s"] < 1e-4
    assert answer["quantised"]["partially_open_samples"] == 0
    assert answer["quantised"]["opposed_firings"] == 0
    whole = answer["quantised_otherwise"]
    assert whole["mode"] == "interval" and whole["partially_open_samples"] == 0
    assert whole["active_intervals"] <= answer["active_intervals"]


@pytest.mark.slow
def test_printed_relative_sparsity_is_judged(thruster_numbers: Any) -> None:
    found = thruster_numbers["findings"]
    assert found["eseo-1"]["reached"]
    assert not found["eseo-2"]["reached"] and found["eseo-2"]["attitude_error_deg"] > 1.0
    assert not found["eseo-3"]["reached"] and found["eseo-3"]["attitude_error_deg"] > 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "best"), [("eseo-1", 1759.7), ("eseo-2", 3094.1), ("eseo-3", 3920.1)]
)
def test_printed_weights_prefer_not_to_brake(thruster_numbers: Any, name: str, best: float) -> None:
    answer = thruster_numbers["penalty"][name]
    assert answer["objective"]["total"] <= best
    assert answer["status"] == "not reached" and answer["alternative"]["status"] == "reached"
    assert answer["alternative"]["objective"]["total"] > best


@pytest.mark.slow
def test_valves_keep_their_shortest_opening(thruster_numbers: Any) -> None:
    assert thruster_numbers["shortest"] >= 0.05 - 1e-9
    assert thruster_numbers["slow"]["status"] == "reached"


@pytest.mark.slow
def test_no_slew_beats_the_impulse_balance(thruster_numbers: Any) -> None:
    study = thruster_numbers["study"]
    for point in (*study["against_intervals"], *study["against_limit"]):
        assert point["reached"]
        assert point["bound_percent"] <= point["percent"]
        assert point["bound_percent"] < point["eigenaxis_percent"]
    percents = [point["percent"] for point in study["against_limit"]]
    assert percents == sorted(percents, reverse=True)


TIMED_PROBE = """
import json
print(json.dumps({
    "rows": comparison.to_dict()["rows"],
    "swept": [[k, rho, r.summary()] for (k, rho), r in swept.items()],
    "saturated": bool(always_saturated.all()),
    "calm": [float(np.abs(calm).max()), straight],
    "half_turn": half_turn.summary(),
}))
"""


@pytest.fixture(scope="module")
def timed(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook(TIMED, tmp_path_factory.mktemp("timed"), TIMED_PROBE)


@pytest.fixture(scope="module")
def timed_numbers(timed: Any) -> Any:
    return json.loads(timed.cells[-1]["outputs"][0]["text"])


@pytest.mark.slow
def test_timed_study_shows_seven_figures(timed: Any) -> None:
    assert len(outputs(timed, "image/png")) == 7
    assert not [o for c in timed.cells for o in c.get("outputs", []) if o.get("name") == "stderr"]


@pytest.mark.slow
def test_the_printed_time_belongs_to_half_the_stated_angle(timed_numbers: Any) -> None:
    time = {(round(r["angle_rad"], 2), r["integration"]): r for r in timed_numbers["rows"]}
    assert time[1.25, "euler"]["final_time_s"] == pytest.approx(24.2124, abs=5e-4)
    assert time[2.5, "euler"]["final_time_s"] > 30.0
    assert time[1.25, "rk4"]["attitude_error_deg"] < 1e-3
    assert time[1.25, "euler"]["attitude_error_deg"] > 0.05


@pytest.mark.slow
def test_time_falls_with_the_wheels_and_effort_rises_where_time_matters(timed_numbers: Any) -> None:
    found = {(k, rho): summary for k, rho, summary in timed_numbers["swept"]}
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


@pytest.mark.slow
def test_torques_saturate_where_time_matters_and_not_where_effort_does(timed_numbers: Any) -> None:
    assert timed_numbers["saturated"]
    largest, straight = timed_numbers["calm"]
    assert largest < 0.5
    # The wheels that do most of the work; the first two hardly turn.
    assert min(straight[2:]) > 0.9
    assert timed_numbers["half_turn"]["final_time_s"] <= 3.2436
