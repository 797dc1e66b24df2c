"""`jaxatt new`: files of every kind that load as they are written."""

import numpy as np
import pytest
from typer.testing import CliRunner

from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.cli.new import Kind
from jaxatt.problems.reading.documents import read_file
from jaxatt.scenarios.beginnings import BEGINNINGS
from jaxatt.studies.file_kinds import faults_of, kind_of_document

RUN = CliRunner()
TARGET = [20.0, -30.0, 40.0]
INERTIA = [1.5, 2.0, 2.5]


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_files_of_every_kind_load_with_the_numbers_that_were_given(kind, tmp_path):
    folder = tmp_path / "mine"
    numbers = ("--inertia", "1.5,2,2.5", "--target", "20,-30,40", "--torque", "0.02")
    done = RUN.invoke(app, ["new", str(folder), "--kind", kind, *numbers])
    assert done.exit_code == 0, done.output
    path = folder / "scenario.toml"
    document = read_file(path)
    assert not faults_of(document, "mine", kind_of_document(document))
    if kind == "flight":
        loaded = scenarios.load_flight(path)
        asked = loaded.asked.q_ob
    else:
        loaded = scenarios.load(path)
        asked = loaded.targets[0].q_ob
    np.testing.assert_allclose(asked, scenarios.quaternion_from_angles(np.deg2rad(TARGET)))
    np.testing.assert_allclose(loaded.vehicle.inertia, np.diag(INERTIA))
    actuators = loaded.vehicle.thrusters if kind == "thrusters" else loaded.vehicle.wheels
    np.testing.assert_allclose(actuators.torque_limit, 0.02)
    assert loaded.name == "mine"


def test_the_kinds_are_those_of_the_command():
    assert [kind.value for kind in Kind] == list(BEGINNINGS)


def test_files_are_not_overwritten_unless_asked(tmp_path):
    assert RUN.invoke(app, ["new", str(tmp_path)]).exit_code == 0
    before = (tmp_path / "vehicle.toml").read_text()
    again = ["new", str(tmp_path), "--inertia", "1,1,1"]
    refused = RUN.invoke(app, again)
    assert refused.exit_code == 2
    assert "--force" in refused.output
    assert (tmp_path / "vehicle.toml").read_text() == before
    assert RUN.invoke(app, [*again, "--force"]).exit_code == 0
    assert (tmp_path / "vehicle.toml").read_text() != before


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--kind", "thrusters", "--wheel-speed", "3"], "--wheel-speed"),
        (["--kind", "minimum-time", "--horizon", "3"], "--horizon"),
        (["--torque", "-1"], "torque_limit_Nm"),
        (["--inertia", "1,2"], "give three"),
        (["--inertia", "a,b,c"], "--inertia"),
        (["--horizon", "0"], "horizon_s"),
    ],
)
def test_numbers_that_make_no_files_are_refused(options, word, tmp_path):
    done = RUN.invoke(app, ["new", str(tmp_path / "x"), *options])
    assert done.exit_code == 2
    assert word in done.output
    assert not (tmp_path / "x").exists()
