"""Sensitivities of scenarios against solving them again; their files and their errors."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import jaxatt
from jaxatt.cli import app
from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.registry import family_of
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer
from jaxatt.studies.sweep.numbers import places, set_at, whole_document

TOY = jaxatt.scenarios.replace(
    jaxatt.scenarios.load("double-integrator"), {"horizon.intervals": 20, "solver.starts": 8}
)
TURN = jaxatt.scenarios.replace(jaxatt.scenarios.load("mrp-k4-rk4"), {"solver.starts": 8})
NAMES = {
    "toy": (TOY, ["control.limit", "initial.state.0", "horizon.horizon_s"]),
    "turn": (
        TURN,
        ["vehicle.wheels.torque_limit_Nm", "vehicle.inertia_kgm2.2.2", "objective.effort_weight"],
    ),
}


def with_number(scenario, name, value):
    document = whole_document(scenario)
    for place in places(scenario, document, name):
        set_at(document, place, value)
    return jaxatt.scenarios.from_mapping(document)


@pytest.fixture(
    scope="module",
    params=["toy", pytest.param("turn", marks=[pytest.mark.slow, pytest.mark.optimised])],
)
def found(request):
    scenario, names = NAMES[request.param]
    answer = sensitive_answer(scenario)
    directions = directions_of(scenario, answer.arguments, names)
    record = answer.optimum.along(directions.names, directions.values, directions.along)
    return scenario, names, answer, record


def test_derivatives_are_those_of_the_answer_at_changed_numbers(found):
    scenario, names, answer, record = found
    assert record.regular
    for k, name in enumerate(names):
        step = 1e-4 * record.values[k]
        ends, paths = [], []
        for sign in (1.0, -1.0):
            changed = with_number(scenario, name, record.values[k] + sign * step)
            # Polished at the changed arguments, with the limits that hold there.
            value, variables = answer.optimum(answer.arguments(changed))
            ends.append(float(value))
            paths.append(np.asarray(variables["controls"]))
        slope = (ends[0] - ends[1]) / (2.0 * step)
        moved = (paths[0] - paths[1]) / (2.0 * step)
        np.testing.assert_allclose(record.by_parameter[k], slope, rtol=1e-5)
        scale = np.abs(moved).max()
        np.testing.assert_allclose(record.variables["controls"][k], moved, atol=1e-4 * scale)


def test_the_search_itself_finds_the_derivative(found):
    scenario, names, _, record = found
    name = names[0]
    ends = []
    for share in (1.01, 0.99):
        changed = jaxatt.scenarios.replace(scenario, {name: record.values[0] * share})
        family = family_of(changed)
        again = family.search(changed, PhaseStart(), SearchOptions(), None)
        ends.append(family.sensitive(changed, PhaseStart(), again).optimum.answer.objective)
    slope = (ends[0] - ends[1]) / (0.02 * record.values[0])
    np.testing.assert_allclose(record.by_parameter[0], slope, rtol=0.05)


def test_the_command_writes_a_table_and_files(tmp_path):
    file = tmp_path / "toy.toml"  # of the shape of the one above, so that nothing compiles again
    text = jaxatt.scenarios.text("double-integrator")
    file.write_text(text.replace("intervals = 100", "intervals = 20"), encoding="utf-8")
    arguments = ["sensitivities", str(file), "--starts", "8", "--out", str(tmp_path)]
    run = CliRunner().invoke(app, [*arguments, "--parameters", "control.limit"])
    assert run.exit_code == 0, run.output
    written = json.loads((tmp_path / "sensitivities.json").read_text())
    assert written["parameters"][0]["parameter"] == "control.limit" and written["regular"]
    assert written["parameters"][0]["derivative"] < 0.0  # more force, less effort
    assert (tmp_path / "sensitivities.png").stat().st_size > 0
    run = CliRunner().invoke(app, [*arguments, "--parameters", "control.limt"])
    assert run.exit_code == 2 and "control.limit" in run.output
