"""Switch times, and how turns in minimum time appear in summary, archive, table and figures."""

import json
import math

import handmade_results
import numpy as np
import pytest

from jaxatt.drawing.figure import picture
from jaxatt.problems.time_optimal.report import panels as time_panels
from jaxatt.problems.time_optimal.switches import switch_times
from jaxatt.report import plots
from jaxatt.report.summary import summary


@pytest.fixture(scope="module")
def turn():
    return handmade_results.timed()


def averaged(times, first, edges, lower, upper):
    """Bang-bang torque with exact switches, averaged over the intervals."""
    fine = np.linspace(edges[0], edges[-1], 200_001)
    middle = 0.5 * (fine[1:] + fine[:-1])
    side = first * (-1.0) ** np.searchsorted(times, middle)
    value = np.where(side > 0, upper, lower)
    sums = np.histogram(middle, edges, weights=value)[0]
    return sums / np.histogram(middle, edges)[0]


@pytest.mark.parametrize("seed", range(5))
def test_switches_are_found_between_the_nodes(seed):
    random = np.random.default_rng(seed)
    edges = np.cumsum(np.r_[0.0, random.uniform(0.5, 1.0, size=60)])
    lower, upper = np.array([-0.5, 0.0, -2.0]), np.array([0.5, 1.0, 1.0])
    # at least three intervals apart, so that both limits are seen between two of them
    wanted = [np.cumsum(random.uniform(4.0, 12.0, size=count)) for count in (1, 2, 3)]
    columns = [
        averaged(times, first, edges, low, high)
        for times, first, low, high in zip(wanted, (1, -1, 1), lower, upper, strict=True)
    ]
    found = switch_times(np.stack(columns, axis=1), edges, lower, upper)
    for times, expected in zip(found, wanted, strict=True):
        np.testing.assert_allclose(times, expected, atol=edges[-1] / 100_000)


def test_a_torque_within_its_limits_has_no_switches():
    torque = np.linspace(0.4, -0.4, 20)[:, None]
    found = switch_times(torque, np.arange(21.0), np.array([-0.5]), np.array([0.5]))
    assert found[0].shape == (0,)


def test_the_summary_holds_time_step_effort_and_optimality(turn):
    found = json.loads(json.dumps(summary(turn)))
    assert found["final_time_s"] == pytest.approx(24.5)
    assert found["step_s"] == pytest.approx(0.7)
    assert found["control_effort"] == pytest.approx(0.7 * (34 * 0.55**2 + 0.11**2))
    assert found["cost"] == pytest.approx(25.0)
    assert found["kkt"] == {"violation": 1e-10, "stationarity": 1e-8}
    block = found["time_optimum"]
    assert block["transcription"]["integration"] == "euler"
    assert block["transcription"]["attitude_error_deg"] == pytest.approx(math.degrees(1e-9))
    # 17 intervals at the limit, and of the next one the share that gives 0.11 on average
    assert block["switch_times_s"]["wheel 1"] == pytest.approx([0.7 * (17 + 0.6)])
    assert block["switch_times_s"]["wheel 2"] == []


def test_other_results_have_time_and_effort_but_no_optimality(make):
    found = summary(make())
    assert (found["final_time_s"], found["step_s"]) == (70.0, 1.4)
    assert found["control_effort"] > 0.0
    assert found["cost"] is None and found["kkt"] is None and found["time_optimum"] is None
    together = summary(make("hypso1-path-two"))
    assert together["final_time_s"] == pytest.approx(140.0)
    assert together["step_s"] == pytest.approx(together["legs"][0]["step_s"])


def test_the_archive_keeps_every_start(turn, tmp_path):
    from jaxatt.report.archive import open_archive, write_archive

    write_archive(turn, tmp_path / "result.nc")
    found = open_archive(tmp_path / "result.nc")
    assert found.start_cost.dims == ("start",)
    assert float(found.final_time) == pytest.approx(24.5)
    assert found.final_time.attrs["units"] == "s"
    assert json.loads(found.attrs["switch_times_s"])[0]["wheel 1"] == pytest.approx([12.32])


def test_the_table_says_time_switches_and_the_transcriptions_error(turn):
    text = " ".join(str(turn).split())
    for words in (
        "final time [s] 24.5",
        "rho = 0.01",
        "wheel 1: 12.32",
        "forward Euler",
        "0.1 (< 0.5)",
    ):
        assert words in text
    assert "active intervals" not in text
    assert "24.5 s" in repr(turn) and "24.5 s" in repr(turn.phases[0])


def test_figures_show_mrp_and_dotted_switches(turn, tmp_path):
    names = {path.stem for path in plots.save_figures(turn, tmp_path)}
    assert {"overview", "mrp", "euler_angles", "torque_wheels", "wheel_speeds", "starts"} <= names
    figure = plots.figures(turn)["torque_wheels"]()
    dotted = [
        [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == ":"]
        for axes in figure.get_axes()
    ]
    assert dotted == [pytest.approx([12.32]), [], [], []]
    assert "24.5000 s" in plots.plot(turn).get_suptitle()


def test_the_mrp_line_stays_within_the_unit_sphere_and_breaks_where_sets_change(turn):
    half = np.linspace(0.0, math.pi, 36) * 0.9  # turns by up to 324 deg
    q = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)
    phase = turn.phases[0]
    series = {**phase.series, "q_ob": q}
    changed = handmade_results.assemble(
        turn.scenario, handmade_results.dataclasses.replace(phase, series=series)
    )
    axes = picture(4, 3).subplots()
    time_panels.modified_rodrigues(axes, changed)
    first = axes.get_lines()[0].get_ydata()
    assert np.nanmax(np.abs(first)) <= 1.0
    assert np.isnan(first).sum() == 1


def test_starts_that_ended_nowhere_are_left_out_of_the_cost_panel(turn):
    axes = picture(4, 3).subplots()
    time_panels.costs_panel(axes, turn.phases[0])
    assert axes.get_ylabel() == "cost [s]"
    marked = np.concatenate([np.asarray(c.get_offsets())[:, 1] for c in axes.collections])
    assert len(marked) == 6 and np.isnan(marked).sum() == 1
