"""Figures hold the panels, units, limits and marks that a reader looks for."""

import numpy as np
import pytest

from jaxatt.drawing.panels import runs
from jaxatt.report import plots
from jaxatt.report.limits import body_torque_limit
from jaxatt.spacecraft.wheels import reaction_wheels


def labels(figure):
    return [axes.get_ylabel().replace("\n", " ") for axes in figure.get_axes()]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_overview_of_a_spacecraft(make):
    figure = plots.plot(make())
    assert labels(figure) == [
        "Euler angles [deg]",
        "rate to orbit frame [deg/s]",
        "body torque [mN m]",
        "wheel torque [mN m]",
        "wheel speeds [rpm]",
        "L1 effort [mN m s]",
    ]
    assert {"window (not priced here)", "coasting"} <= set(legend(figure.get_axes()[0]))
    assert "3 active intervals" in figure.get_suptitle()


def test_legs_share_one_time_axis(make):
    figure = plots.plot(make("hypso1-path-two"))
    first = figure.get_axes()[0]
    assert first.get_xlim() == pytest.approx((0.0, 168.0))
    assert [text.get_text() for text in first.texts] == ["leg 1", "leg 2"]
    assert [axes.get_title() for axes in figure.get_axes()[-2:]] == [
        "leg 1: 6 starts",
        "leg 2: 6 starts",
    ]


def test_forbidden_and_priced_windows_differ(make):
    forbidden = np.zeros(50, bool)
    forbidden[30:40] = True
    result = make(forbidden=forbidden)
    axes = plots.figures(result)["euler_angles"]().get_axes()[0]
    assert {"window (not priced here)", "torque forbidden"} <= set(legend(axes))


def test_the_waypoint_is_marked(make):
    axes = plots.figures(make("hypso1-path"))["euler_angles"]().get_axes()[0]
    assert "waypoint" in legend(axes)


def test_files_of_a_spacecraft_and_of_a_toy(make, tmp_path):
    written = plots.save_figures(make(), tmp_path / "craft")
    names = {path.stem for path in written}
    assert names == {
        "overview",
        "euler_angles",
        "omega_ob",
        "torque_body",
        "torque_wheels",
        "wheel_speeds",
        "starts",
    }
    assert {path.stem for path in (tmp_path / "craft").iterdir()} == names
    written = plots.save_figures(make("double-integrator"), tmp_path / "toy")
    assert {path.stem for path in written} == {"overview", "control", "state", "starts"}
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)


def test_side_by_side(make):
    figure = plots.compare({"L1": make(), "L0": make()})
    assert len(figure.get_axes()) == 10


def test_a_picture_shows_itself_in_a_notebook(make):
    assert plots.plot(make("double-integrator"))._repr_png_().startswith(b"\x89PNG")


def test_torque_limits_bound_every_body_torque_that_the_wheels_can_give(make):
    scenario = make().scenario
    allocation = np.asarray(scenario.vehicle.wheels.allocation)
    allocated = body_torque_limit(scenario.vehicle.wheels, allocated=True)
    torque = np.random.default_rng(0).uniform(-6e-3, 6e-3, (20000, 3))
    inside = torque[(np.abs(torque @ allocation.T) <= 3e-3).all(axis=1)]
    assert (np.abs(inside).max(axis=0) <= allocated).all()
    assert (np.abs(inside).max(axis=0) > 0.8 * allocated).all()
    orthogonal = reaction_wheels(np.eye(3), 1e-4, [1e-3, 2e-3, 3e-3])
    for shared in (True, False):
        assert body_torque_limit(orthogonal, shared) == pytest.approx([1e-3, 2e-3, 3e-3])


def test_runs():
    mask = np.array([True, False, True, True, False])
    assert runs(mask) == [(0, 1), (2, 4)]
