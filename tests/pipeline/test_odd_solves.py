"""Odd values that a file may hold are solved honestly: nothing raises, nothing is half-written."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from references.odd_values import odd_documents
from typer.testing import CliRunner

import jaxatt
from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.problems.time_optimal.actuation import actuation
from jaxatt.spacecraft import create, reaction_wheels, thrusters

SMALL = {"horizon.intervals": 12, "horizon.coast_intervals": 4, "solver.starts": 4}


def small(changes=None):
    return scenarios.replace(scenarios.load("double-integrator"), {**SMALL, **(changes or {})})


def compiled_alike(scenario):
    """Whether a scenario has the shapes of the small one, so that nothing new is compiled."""
    same, horizon = small(), scenario.horizon
    return (
        (horizon.intervals, horizon.coast_intervals, horizon.substeps, horizon.free)
        == (same.horizon.intervals, same.horizon.coast_intervals, None, False)
        and scenario.objective.kind == same.objective.kind
        and scenario.solver.starts == same.solver.starts
        and not scenario.windows
    )


@settings(
    derandomize=True,
    database=None,
    deadline=None,
    max_examples=60,
    suppress_health_check=list(HealthCheck),
)
@given(odd_documents(("double-integrator",)))
def test_whatever_loads_is_solved(odd):
    _, _, _, document = odd
    try:
        scenario = scenarios.from_mapping(document)
        scenario = scenarios.replace(scenario, SMALL)
    except scenarios.ScenarioError:
        assume(False)
    assume(compiled_alike(scenario))
    honest(jaxatt.solve(scenario))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("horizon.horizon_s", 1e9),
        ("horizon.horizon_s", 1e-30),
        ("initial.state", [1e30, -1e30]),
        ("initial.state", [1e-300, 0.0]),
        ("target.state", [1e30, 0.0]),
        ("target.tolerance", 1e-30),
        ("control.limit", 1e30),
        ("control.limit", 1e-30),
        ("objective.epsilon", 1e30),
    ],
)
def test_extreme_sizes(key, value):
    honest(jaxatt.solve(small({key: value})))


def honest(result):
    """An answer that is called reached is within its tolerance when flown."""
    (phase,) = result.phases
    error, tolerance = phase.errors["state"], result.scenario.targets[0].state_tolerance
    assert result.reached == bool(error <= tolerance)
    assert str(result)


@pytest.mark.parametrize("changed", ["intervals = 1", "intervals = 2"])
def test_the_command_with_hardly_any_intervals(tmp_path, monkeypatch, changed):
    monkeypatch.chdir(tmp_path)
    text = scenarios.text("double-integrator").replace("intervals = 100", changed)
    (tmp_path / "few.toml").write_text(text)
    found = CliRunner().invoke(app, ["solve", "few.toml", "--starts", "2", "--out", "there"])
    assert found.exit_code in (0, 3), found.output
    assert found.exception is None or isinstance(found.exception, SystemExit)
    summary = json.loads((tmp_path / "there/summary.json").read_text())
    assert (summary["status"] == "reached") == (found.exit_code == 0)
    assert {"result.nc", "summary.json"} <= {file.name for file in (tmp_path / "there").iterdir()}


def test_thrusters_of_one_torque_are_one_control():
    rng = np.random.default_rng(16)
    columns = np.concatenate([np.eye(3), -np.eye(3)], axis=1)
    limit = rng.uniform(0.5, 2.0, 6)
    wheels = reaction_wheels(np.eye(3), 1e-3, 1e-2)
    six = actuation(create(np.eye(3), wheels, thrusters=thrusters(columns, limit)))
    twice = thrusters(np.concatenate([columns, columns], axis=1), np.tile(0.5 * limit, 2))
    twelve = actuation(create(np.eye(3), wheels, thrusters=twice))
    assert twelve.size == six.size == 6
    u = rng.uniform(-1.5, 1.5, (20, 6))
    torque, doubled = six.torques(u), twelve.torques(u)
    np.testing.assert_allclose(doubled[:, 3:9] + doubled[:, 9:], torque[:, 3:], atol=1e-15)
    np.testing.assert_allclose(twelve.to_external, six.to_external, atol=1e-15)
    inside = np.clip(u, twelve.lower, twelve.upper)
    effort = ((twelve.scale * inside) ** 2).sum(axis=1)
    np.testing.assert_allclose(effort, (doubled**2).sum(axis=1), rtol=1e-12)
