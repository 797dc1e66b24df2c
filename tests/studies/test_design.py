"""Numbers of a scenario chosen by descent, beside scaling laws, grids and re-solves."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jaxatt
from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.problems.reading.documents import parse
from jaxatt.studies.design.design import design
from jaxatt.studies.design.evaluate import Evaluator
from jaxatt.studies.design.reading import load_design, read_design

RNG = np.random.default_rng(1129)
TORQUE = {
    "field": "vehicle.wheels.torque_limit_Nm.*",
    "from": 0.05,
    "to": 4.0,
    "spacing": "logarithmic",
}
MOUNTING = [
    {"field": "vehicle.wheels.azimuth_deg.3", "from": -90.0, "to": 90.0},
    {"field": "vehicle.wheels.elevation_deg.3", "from": -90.0, "to": 90.0},
]
WHEELS = {"azimuth_deg": [0.0, 90.0, 0.0, 50.0], "elevation_deg": [0.0, 0.0, 90.0, 30.0]}
TURNS = [
    {"attitude_deg": [float(x) for x in RNG.uniform(20.0, 90.0, 3) * RNG.choice([-1.0, 1.0], 3)]}
    for _ in range(3)
]


def study(design, **changes):
    """Least times of a turn with four wheels, one of them along no axis, on a coarse grid."""
    document = {
        "scenario": "mrp-k4-rk4",
        "fixed": {
            "objective": {"kind": "minimum-time"},
            "solver": {"starts": 4},
            "horizon": {"intervals": 12, "substeps": 4},
            "vehicle": {"wheels": WHEELS},
        },
        "design": design,
        **changes,
    }
    return read_design(copy.deepcopy(document), "d.toml")


def times_at(found, values):
    """Least times of a study at other values of its only variable, searched afresh."""
    low, high = found.variables[0].range.low, found.variables[0].range.high
    return Evaluator(found).fresh(np.array([np.log(values / low) / np.log(high / low)])).measured


@pytest.fixture(scope="module")
def smallest():
    """The least torque limit for a random time, from one point."""
    limit = float(RNG.uniform(22.0, 45.0))
    return design(
        study([TORQUE], minimise="torque_limit_Nm", at_most={"final_time_s": limit}, points=1)
    )


def test_a_smaller_torque_limit_takes_too_long_and_a_larger_one_does_not(smallest) -> None:
    most, found = smallest.study.at_most, smallest.values["torque_limit_Nm"]
    assert times_at(smallest.study, 0.999 * found)[0] > most
    assert times_at(smallest.study, 1.001 * found)[0] < most
    assert smallest.measured == pytest.approx(most, rel=1e-4)


def test_smallest_torque_limit_follows_the_scaling_of_time(smallest) -> None:
    # From rest to rest, a turn with the same path takes time as 1 / sqrt(torque).
    other = float(RNG.uniform(0.3, 2.0))
    time = times_at(smallest.study, other)[0]
    exact = other * (time / smallest.study.at_most) ** 2
    assert smallest.values["torque_limit_Nm"] == pytest.approx(exact, rel=1e-4)


def test_the_end_is_flown_drawn_and_saved(smallest, tmp_path) -> None:
    assert smallest.reached and smallest.flown.reached.all()
    assert smallest.flown.result is not None and smallest.flown.result.reached
    assert smallest.flown.measured[0] == pytest.approx(smallest.measured, rel=1e-3)
    files = smallest.save(tmp_path / "out")
    assert [file.name for file in files] == ["design.json", "design.png"]
    told = json.loads(files[0].read_text(encoding="utf-8"))
    assert told["values"] == smallest.values
    assert len(told["tried"]) == len(smallest.tried) > 2
    assert "torque_limit_Nm" in str(smallest) and "at most" in str(smallest)
    drawn = smallest.plot().axes[1].lines[0].get_ydata()
    np.testing.assert_array_equal(drawn, [e.shares[0] for e in smallest.tried])


def test_slopes_are_the_differences_of_answers_followed() -> None:
    found = study([*MOUNTING, TORQUE], targets=TURNS[:1])
    evaluator, step = Evaluator(found), 2e-4
    shares = RNG.uniform(0.2, 0.8, 3)
    middle = evaluator.fresh(shares)
    for d in range(3):
        ends = []
        for sign in (1.0, -1.0):
            evaluator.go_on_from(middle)
            ends.append(evaluator(shares + sign * step * np.eye(3)[d]).measured[0])
        slope = (ends[0] - ends[1]) / (2.0 * step)
        assert middle.slopes[0, d] == pytest.approx(slope, abs=3e-4 * middle.measured[0])
    assert np.abs(middle.slopes).min() > 0.0


def test_mounting_is_no_worse_than_a_grid() -> None:
    found = design(study(MOUNTING))
    evaluator = Evaluator(found.study)
    shares = np.linspace(0.0, 1.0, 5)
    grid = [evaluator.fresh(np.array([a, b])).measured[0] for a in shares for b in shares]
    assert found.measured <= min(grid) * (1.0 + 1e-6)
    assert found.measured < 0.95 * np.median(grid)
    assert found.reached


@pytest.mark.parametrize("over", ["worst", pytest.param("mean", marks=pytest.mark.slow)])
def test_a_limit_over_many_targets_is_met_exactly(over: str) -> None:
    most = float(RNG.uniform(25.0, 50.0))
    found = design(
        study(
            [TORQUE],
            minimise="torque_limit_Nm",
            at_most={"final_time_s": most},
            over=over,
            targets=TURNS,
            points=1,
        )
    )
    other = float(RNG.uniform(0.3, 2.0))
    times = times_at(found.study, other)
    folded = times.max() if over == "worst" else times.mean()
    assert found.values["torque_limit_Nm"] == pytest.approx(other * (folded / most) ** 2, rel=1e-4)
    assert found.flown.reached.all() and len(found.flown.reached) == 3


def test_time_and_effort_are_measured_together() -> None:
    found = design(
        study(
            MOUNTING[1:],
            fixed={
                "objective": {"effort_weight": float(RNG.uniform(0.05, 0.5))},
                "solver": {"starts": 4},
                "horizon": {"intervals": 12, "substeps": 4},
                "vehicle": {"wheels": WHEELS},
            },
            targets=TURNS,
            over="mean",
            points=2,
        )
    )
    assert found.study.measure == "cost" and found.reached
    first = min(found.study.over_targets(e.measured) for e in found.tried[:2])
    assert found.measured < first
    inside = (found.best.shares > 1e-6) & (found.best.shares < 1.0 - 1e-6)
    slope = found.best.slopes.mean(axis=0)[inside]
    assert np.abs(slope).max(initial=0.0) < 2e-3 * found.measured


def test_no_design_nearby_has_a_smaller_worst_time() -> None:
    # Where the worst target changes, the worst time has a corner.
    found = design(study(MOUNTING[1:], targets=TURNS, over="worst", points=3))
    evaluator = Evaluator(found.study)
    nearby = np.clip(found.best.shares + np.linspace(-0.05, 0.05, 7)[:, None], 0.0, 1.0)
    around = []
    for shares in nearby:
        evaluator.go_on_from(found.best)
        around.append(evaluator(shares).measured.max())
    assert found.measured <= min(around) * (1.0 + 1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"design": [{**TORQUE, "field": "vehicle.wheels.torque"}]}, r"did you mean '.*torque_"),
        ({"design": [{**TORQUE, "to": 0.01}]}, r"to = 0.01: is not above from = 0.05"),
        ({"design": [{**TORQUE, "values": [1.0]}]}, r"\[\[design\]\] no. 1 values = .* for sweeps"),
        ({"minimise": "torque_limit_Nm"}, r"minimise .*: needs a limit.*at_most = { final_time_s"),
        ({"minimise": "torque_limit"}, r"did you mean 'torque_limit_Nm'\?"),
        ({"at_most": {"final_time_s": 30.0}}, r"at_most: limits final_time_s, which is minimised"),
        (
            {"minimise": "torque_limit_Nm", "at_most": {"final_time_s": -1.0}},
            r"\[at_most\] final_time_s = -1.0: must be greater than 0",
        ),
        ({"targets": 0}, r"targets = 0: must be at least 1"),
        ({"targets": []}, r"targets = \[\]: is no list of attitudes"),
        ({"targets": [{"attitude_deg": [1.0, 2.0]}]}, r"attitude_deg = .*: has 2 entries"),
        ({"over": "best"}, r"over = \"best\": not one of the choices"),
        ({"points": 0}, r"points = 0: must be at least 1"),
        ({"fixed": {}, "scenario": "hypso1-90-45-15"}, r"hypso1-90-45-15 is no turn in free time"),
        ({"outputs": ["cost"]}, r"outputs = .*: unknown key"),
    ],
)
def test_what_makes_no_sense_is_said_in_a_sentence(changes, message: str) -> None:
    with pytest.raises(jaxatt.ScenarioError, match=message):
        study(**{"design": [TORQUE], **changes})


@pytest.mark.parametrize("name", scenarios.names("design"))
def test_bundled_designs_are_read(name: str) -> None:
    found = load_design(name, {"solver.starts": 2})
    assert found.name == name and found.scenario.solver.starts == 2
    for share in (0.0, 0.5, 1.0):
        found.scenario_at(np.full(len(found.variables), share))


def test_the_study_of_the_page_is_read() -> None:
    page = (Path(__file__).parents[2] / "docs" / "design.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.S)
    found = read_design(parse(text, "page"))
    assert found.names == ("wheel_size",) and found.at_most is not None


def test_the_command_refuses_in_a_sentence(tmp_path) -> None:
    for case, message in (
        ("smallest-torgue", "did you mean 'smallest-torque'?"),
        ("mrp-k4", "neither a bundled study nor a file"),
    ):
        told = CliRunner().invoke(app, ["design", case, "--out", str(tmp_path / "out")])
        assert told.exit_code == 2 and message in told.stderr
    assert not (tmp_path / "out").exists()


def test_a_limit_out_of_reach_names_the_nearest() -> None:
    tried = study([TORQUE], minimise="torque_limit_Nm", at_most={"final_time_s": 3.0}, points=1)
    with pytest.raises(jaxatt.ScenarioError, match=r"final_time_s = 3: the least .* is") as told:
        design(tried)
    least = times_at(tried, 4.0)[0]
    assert f"{least:.5g}"[:4] in str(told.value) and "torque_limit_Nm = 4" in str(told.value)
