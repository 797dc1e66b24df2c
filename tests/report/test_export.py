"""Files for other tools of results that were saved."""

import datetime as dt
import math

import handmade_results
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.exchange.aem_reading import read_aem
from jaxatt.exchange.moments import seconds_after
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.archive import open_archive, write_archive
from jaxatt.report.export.export import export
from jaxatt.report.export.files import Format
from jaxatt.report.export.saved_motion import saved_motion

EPOCH = dt.datetime(2026, 6, 21, 12, 0, 0, 125000, dt.UTC)


def saved(result, folder):
    folder.mkdir()
    write_archive(result, folder / "result.nc")
    return folder


def coupled(scenario):
    """A phase whose rates are those of its attitudes, relative to the orbit frame."""
    count = scenario.horizon.intervals
    step = scenario.horizon.step
    nodes = count + scenario.horizon.coast_intervals + 1
    half = 0.005 * step * np.arange(nodes)
    q = np.stack([np.cos(half), 0.6 * np.sin(half), 0 * half, 0.8 * np.sin(half)], axis=1)
    omega = np.tile(0.01 * np.array([0.6, 0.0, 0.8]), (nodes, 1))
    phase = handmade_results.spacecraft_phase(scenario)
    return handmade_results.changed(phase, series={**phase.series, "q_ob": q, "omega_ob": omega})


def orbit_of(path):
    """Seconds after midnight, positions and velocities [km] of an OEM, by the standard's rules."""
    lines = path.read_text().partition("META_STOP")[2].split("\n")
    rows = [line.split() for line in lines if line.strip()]
    clock = np.array([row[0] for row in rows], "datetime64[ns]")
    return (
        clock,
        np.array([row[1:4] for row in rows], float),
        np.array([row[4:] for row in rows], float),
    )


@pytest.fixture(scope="module")
def slew(tmp_path_factory):
    scenario = scenarios.load("hypso1-90-45-15")
    result = handmade_results.assemble(scenario, coupled(scenario))
    return saved(result, tmp_path_factory.mktemp("export") / "slew")


def test_the_attitude_is_the_orbit_frame_s_and_the_body_s_in_it(slew, tmp_path) -> None:
    files = [file.path for file in export(slew, tmp_path, epoch=EPOCH, orbit=True)]
    assert [file.name for file in files] == ["hypso1-90-45-15.aem", "hypso1-90-45-15.oem"]
    (segment,) = read_aem(files[0])
    moments, place, speed = orbit_of(files[1])
    start = np.datetime64(EPOCH.replace(tzinfo=None), "ns")
    assert segment.moments[0] == start == moments[0] and segment.moments[-1] == moments[-1]
    archive = open_archive(slew / "result.nc")
    nodes, q_ob = archive["time"].to_numpy(), archive["q_ob"].to_numpy()
    # The orbit frame, from the orbit's file alone: down, against the orbit's normal, forward.
    down = -place / np.linalg.norm(place, axis=1, keepdims=True)
    across = -np.cross(place, speed)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    r_io = Rotation.from_matrix(np.stack([np.cross(across, down), across, down], axis=2))
    times = seconds_after(start, segment.moments)
    for k in (0, len(moments) - 1):
        t = seconds_after(start, moments[[k]])[0]
        node = int(np.argmin(np.abs(nodes - t)))
        wanted = r_io[k] * Rotation.from_quat(q_ob[node], scalar_first=True)
        row = int(np.argmin(np.abs(times - t)))
        found = Rotation.from_quat(segment.q_ib[row], scalar_first=True)
        assert math.degrees((wanted.inv() * found).magnitude()) < 1e-7
    assert (np.min(np.abs(times[:, None] - nodes), axis=0) < 1e-8).all()  # nodes among the rows
    assert len(times) == 10 * (len(nodes) - 1) + 1


def test_between_the_nodes_the_attitude_moves_as_its_rate_says(slew, tmp_path) -> None:
    (file,) = export(slew, tmp_path, epoch=EPOCH, step=0.2)
    (segment,) = read_aem(file.path)
    times = seconds_after(segment.moments[0], segment.moments)
    turns = Rotation.from_quat(segment.q_ib, scalar_first=True)
    moved = (turns[:-1].inv() * turns[1:]).as_rotvec() / np.diff(times)[:, None]
    mean = 0.5 * (segment.omega_ib[1:] + segment.omega_ib[:-1])
    np.testing.assert_allclose(moved, mean, atol=1e-8)
    assert np.diff(times).max() <= 0.2 + 1e-9


@pytest.mark.parametrize("form", Format)
def test_every_format_is_written(slew, tmp_path, form) -> None:
    (file,) = export(slew, tmp_path, form=form, epoch=EPOCH)
    assert "attitudes from 2026-06-21T12:00:00.125Z" in file.contents
    assert len(file.path.read_text()) > 10_000


def test_phases_that_join_are_one_span_and_others_are_not(tmp_path) -> None:
    scenario = scenarios.load("hypso1-path-two")
    phases = [handmade_results.spacecraft_phase(scenario, i) for i in range(2)]
    apart = saved(handmade_results.assemble(scenario, *phases), tmp_path / "apart")
    assert len(saved_motion(apart).paths) == 2
    (file,) = export(apart, tmp_path, epoch=EPOCH)
    first, second = read_aem(file.path)
    assert first.moments[-1] == second.moments[0]
    count = scenario.horizon.intervals
    joined = {name: phases[0].series[name][count] for name in ("q_ob", "omega_ob")}
    series = dict(phases[1].series)
    for name, value in joined.items():
        series[name] = np.concatenate([value[None], series[name][1:]])
    phases[1] = handmade_results.changed(phases[1], series=series)
    together = saved(handmade_results.assemble(scenario, *phases), tmp_path / "together")
    (path,) = saved_motion(together).paths
    assert (np.diff(path.time) > 0.0).all()
    assert path.time[-1] == pytest.approx(
        2 * scenario.horizon.duration + scenario.horizon.coast_intervals * scenario.horizon.step
    )


def test_phases_of_other_steps_follow_one_another(tmp_path) -> None:
    scenario = scenarios.load("hypso1-path-two")
    step, duration = scenario.horizon.step, scenario.horizon.duration
    phases = [handmade_results.spacecraft_phase(scenario, i) for i in range(2)]
    phases[1] = handmade_results.changed(phases[1], step=2.0 * step)
    folder = saved(handmade_results.assemble(scenario, *phases), tmp_path / "steps")
    first, second = saved_motion(folder).paths
    np.testing.assert_allclose(np.diff(first.time), step)
    np.testing.assert_allclose(np.diff(second.time), 2.0 * step)
    assert (first.time[-1], second.time[0]) == pytest.approx((duration, duration))


def test_turns_without_an_orbit_are_inertial(tmp_path) -> None:
    result = handmade_results.timed()
    folder = saved(result, tmp_path / "timed")
    motion = saved_motion(folder)
    np.testing.assert_array_equal(motion.paths[0].q, result.phases[0].series["q_ob"])
    with pytest.raises(ScenarioError, match="has no orbit; leave --orbit out"):
        export(folder, tmp_path, epoch=EPOCH, orbit=True)


def test_what_cannot_be_exported_says_why(slew, tmp_path) -> None:
    with pytest.raises(ScenarioError, match=r"has no epoch.*--epoch 2026-06-21T12:00:00Z"):
        export(slew, tmp_path)
    toy = saved(handmade_results.handmade("double-integrator"), tmp_path / "toy")
    for place, words in (
        (toy, "holds no attitude"),
        (tmp_path, "holds neither result.nc nor flight.nc"),
        (tmp_path / "missing", "holds neither"),
    ):
        with pytest.raises(ScenarioError, match=words):
            saved_motion(place)
    (tmp_path / "result.nc").write_text("no archive")
    with pytest.raises(ScenarioError, match="is no archive of a result"):
        saved_motion(tmp_path)
    with pytest.raises(ScenarioError, match="run 3: it has one run only"):
        saved_motion(slew, 3)
    with pytest.raises(ScenarioError, match="give a longer one"):
        export(slew, tmp_path, epoch=EPOCH, step=1e-6)


def test_the_scenario_s_own_epoch_is_taken(tmp_path) -> None:
    scenario = scenarios.replace(
        scenarios.load("hypso1-90-45-15"), {"orbit.epoch": EPOCH.isoformat()}
    )
    result = handmade_results.assemble(scenario, coupled(scenario))
    (file,) = export(saved(result, tmp_path / "dated"))
    assert file.path.parent == tmp_path / "dated"
    assert "from 2026-06-21T12:00:00.125Z to" in file.contents


def test_the_command_says_what_it_wrote_or_what_it_lacks(slew, tmp_path) -> None:
    def run(*options):
        return CliRunner().invoke(app, ["export", str(slew), "--out", str(tmp_path), *options])

    found = run("--format", "stk", "--epoch", "2026-06-21T12:00:00Z", "--object-id", "2022-002B")
    assert found.exit_code == 0 and "hypso1-90-45-15.a: 701 attitudes" in found.output
    assert run("--epoch", "2026-06-21", "--quiet").output.strip().endswith("hypso1-90-45-15.aem")
    for options, words in (
        ((), "has no epoch"),
        (("--name", "a\nb"), "is no name for"),
        (("--epoch", "noon"), "epoch noon: is no moment"),
    ):
        found = run(*options)
        assert found.exit_code == 2 and words in found.output
