"""A free final time in summary, table, dataset and figures."""

import dataclasses
import json

import numpy as np
import pytest
from handmade_results import assemble, changed

from jaxatt.drawing.rendering import as_text
from jaxatt.problems.hands_off.record import FinalTimes
from jaxatt.records.pointing import Extreme, PointingRecord
from jaxatt.report import plots
from jaxatt.report.archive import open_archive, write_archive
from jaxatt.report.dataset import to_dataset
from jaxatt.report.summary import summary, write_summary
from jaxatt.studies.controllers_table import comparison_table

TRIED = FinalTimes(
    time_weight=0.1,
    cost=9.4,
    final_time=np.array([90.0, 64.0, 50.0]),
    costs=np.array([12.0, 9.4, np.inf]),
    active_intervals=np.array([3, 3, 1]),
    reached=np.array([True, True, False]),
    how=("search", "support", "exchange"),
)


@pytest.fixture
def timed(make):
    """Two phases with steps of their own, one with fewer trials than the other."""
    result = make("hypso1-path-two")
    first, second = result.phases
    fewer = {
        field: getattr(TRIED, field)[:2]
        for field in ("final_time", "costs", "active_intervals", "reached", "how")
    }
    return assemble(
        result.scenario,
        changed(first, step=1.28, final_times=TRIED),
        changed(second, start_time=64.0, step=1.0, final_times=dataclasses.replace(TRIED, **fewer)),
    )


def test_every_summary_tells_final_time_and_step(make):
    found = summary(make())
    assert found["final_time_s"] == pytest.approx(70.0)
    assert found["step_s"] == pytest.approx(1.4)
    assert found["final_times"] is None
    both = summary(make("hypso1-path-two"))
    assert both["final_time_s"] == pytest.approx(140.0)
    assert both["step_s"] == pytest.approx(1.4)


def test_the_trials_are_listed_by_leg(timed, tmp_path):
    write_summary(timed, tmp_path / "summary.json")
    found = json.loads((tmp_path / "summary.json").read_text())
    assert found["final_time_s"] == pytest.approx(114.0)
    assert found["step_s"] is None
    assert [phase["final_time_s"] for phase in found["legs"]] == [64.0, 50.0]
    tried = found["legs"][0]["final_times"]
    assert (tried["time_weight_1_s"], tried["cost"]) == (0.1, 9.4)
    assert tried["tried"][2] == {
        "final_time_s": 50.0,
        "cost": None,
        "active_intervals": 1,
        "reached": False,
        "how": "exchange",
    }


def test_the_table_tells_the_final_time_only_where_it_was_free(make, timed):
    assert "final time" not in str(make())
    shown = str(timed)
    assert "final time [s]" in shown
    assert "64 (1.28 an" in shown
    assert "9.4 (3 final" in shown


def test_a_comparison_tells_final_times_that_differ():
    def table(*final_times):
        printed = {"active_intervals": None, "active_outside_windows": None, "cpu_time_s": None}
        row = {
            "controller": "L0",
            "reached": True,
            "active_intervals": 2,
            "active_interval_indices": (0, 49),
            "weighted_active_intervals": 2.0,
            "active_outside_windows": 2,
            "attitude_error_deg": 1e-6,
            "rate_error_rad_s": 1e-9,
            "waypoint_error_deg": None,
            "state_error": None,
            "l1_effort_Nms": 6e-3,
            "objective_total": 20.0,
            "starts_reached": 8,
            "starts": 8,
            "time_s": 1.0,
            "axes": "body",
            "printed": printed | {"relative_sparsity_percent": None},
        }
        return as_text(comparison_table("case", [row | {"final_time_s": t} for t in final_times]))

    assert "final time" not in table(70.0, 70.0)
    assert "41.49" in table(70.0, 41.493)


def test_legs_of_different_steps_share_a_dataset(timed, tmp_path):
    write_archive(timed, tmp_path / "result.nc")
    found = open_archive(tmp_path / "result.nc")
    assert found.identical(to_dataset(timed))
    np.testing.assert_allclose(found.node_time.values[:, 50], [64.0, 50.0])
    np.testing.assert_allclose(found.interval_start.values[:, 1], [1.28, 1.0])
    assert found.leg_start.values.tolist() == [0.0, 64.0]
    np.testing.assert_array_equal(found.trial_cost.values, [[12, 9.4, np.inf], [12, 9.4, np.nan]])


@pytest.mark.parametrize("costs", [[0.0, 0.0, 0.0], [29.3, 28.9, np.inf], [np.inf] * 3])
def test_the_figure_bears_costs_of_any_kind(make, costs):
    """Zero, of a printed cost that nothing reached, and none at all."""
    record = dataclasses.replace(
        TRIED, cost=min(costs), costs=np.array(costs), reached=np.zeros(3, bool)
    )
    result = make(final_times=record, active=np.zeros(50, bool))
    figure = plots.figures(result)["final_times"]()
    figure.canvas.draw()
    assert len(figure.get_axes()) == 2


def test_the_figure_marks_the_answer(make, timed):
    assert "final_times" not in plots.figures(make())
    axes = plots.figures(timed)["final_times"]().get_axes()
    assert len(axes) == 4
    stars = [a.collections[-1].get_offsets() for a in axes]
    assert (64.0, 9.4) in [tuple(star[0]) for star in stars]
    assert axes[-1].get_xlabel() == "final time [s]"
    words = [text.get_text() for text in axes[0].get_legend().get_texts()]
    assert words == ["cheapest answer", "none of those tried reached"]


def test_cones_of_legs_of_different_steps_share_a_dataset(timed):
    """The fine instants are at other times in every leg: they are numbered."""

    def watched(phase):
        time = np.linspace(0.0, phase.final_time, 101)
        record = PointingRecord(
            time=time,
            angles=np.full((101, 1), 1.0 + phase.start_time),
            boresights=np.zeros((101, 1, 3)),
            directions=np.zeros((101, 1, 3)),
            extremes=(Extreme("sun", "keep-out", 1.0, 0.5, 0.0, True),),
            constraint_margin=np.zeros(1),
        )
        return changed(phase, pointing=record)

    first, second = timed.phases
    found = to_dataset(assemble(timed.scenario, watched(first), watched(second)))
    assert found.cone_angle.dims == ("leg", "fine_time", "cone")
    np.testing.assert_allclose(found.fine_node_time.values[:, -1], [64.0, 50.0])
    np.testing.assert_array_equal(found.fine_time, np.arange(101))
    np.testing.assert_array_equal(found.cone_angle.values[:, 0, 0], [1.0, 65.0])
    alone = to_dataset(assemble(timed.scenario, watched(first)))
    assert float(alone.fine_time[-1]) == 64.0 and "fine_node_time" not in alone
