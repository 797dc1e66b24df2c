"""All faults of a file are told at once, whatever finds them."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from jaxatt import scenarios
from jaxatt.problems.reading.fields import ScenarioError, ScenarioErrors
from jaxatt.problems.reading.lines import located
from jaxatt.scenarios.flight_loader import flight_from_mapping
from jaxatt.scenarios.loader import assign, from_mapping
from jaxatt.studies.file_kinds import faults_of

BAD_WINDOW = {"first_interval": 5, "last_interval": 2}
CONE = {"name": "sun", "boresight": [1.0, 0.0, 0.0], "direction_inertial": [1.0, 0.0, 0.0]}

FAULTS = {
    "hypso1-90-45-15": {
        "vehicle": {"use": "hypso1", "wheels": {"failed": ["wheel 9"]}},
        "solver.starts": -1,
        "objective.design": 4,
        "windows": [{"first_interval": 3, "last_interval": 99}, BAD_WINDOW],
        "target.attitude_tolerance_deg": "small",
        "orbit.eccentricity": 1.5,
        "control": {"quantisation": "interval", "axis": "body"},
    },
    "hypso1-90-45-15-keep-out": {
        "waypoint": {"time_s": 500.0, "attitude_deg": [1.0, 2.0, 3.0], "tolerance_deg": 1.0},
        "keep_out": [{**CONE, "half_angle_deg": 200.0}, {**CONE, "half_angle_deg": "wide"}],
        "initial": {"attitude_deg": [0.0, 0.0, 0.0], "at": "2026-06-21T12:00:00Z"},
        "objective.time_weight_1_s": 1.0,
        "solver.seeds": 3,
        "limits": {"body_rate_deg_s": [1.0, -1.0, 1.0]},
    },
    "eseo-1": {
        "vehicle.thrusters.minimum_on_time_s": -3.0,
        "vehicle.inertia_kgm2": [[4.3, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 30.7]],
        "horizon.intervals": 0,
        "initial.attitude_deg": [1.0, 2.0],
        "objective.kindd": "l0",
        "solver.seed": -4,
    },
    "mrp-k4": {
        "vehicle.wheels.torque_limit_Nm": [0.1, 0.2],
        "objective.design": 2,
        "horizon.horizon_s": 30.0,
        "control": {"axes": "body"},
        "windows": [BAD_WINDOW],
        "transcription.attitude": "euler",
    },
    "hypso1-netpower": {
        "vehicle": {
            "use": "hypso2",
            "battery": {"capacity_Wh": 10.0, "charge_Wh": 20.0},
            "panels": {"shades": 9},
        },
        "horizon.coast_intervals": 3,
        "initial.frame": "moon",
        "title": 5,
        "printed.rows": [{"label": "a", "net_J": "many"}, {"label": "b", "net_J": []}],
        "baseline.turn_back_s": -1.0,
        "limits": {"least_charge_percent": 120.0},
    },
    "double-integrator": {
        "objective.terminal": "penalty",
        "horizon.longest_s": 2.0,
        "solver.starts": 0,
        "target.state": [1.0],
        "control.limit": "1 N",
    },
    "hypso1-pointing": {
        "simulation.duration_s": -5.0,
        "initial.attitude_deg": [1.0],
        "orbit.elements": "mean",
        "laws.pd.kind": "pdd",
        "laws.a/b": {"kind": "pd"},
        "titel": "a letter in another place",
        "laws.smc.lambda": 3,
        "noise.rate_rad_s": -1.0,
        "vehicle.wheels": {"inertia_kgm2": -1.0},
    },
}
"""Scenario or flight -> new values with a fault in each, by their names."""


def messages(name: str, changes: dict) -> set[str]:
    """What is told of a changed file, one sentence a fault."""
    document = tomllib.loads(scenarios.text(name))
    for key, value in changes.items():
        assign(document, key, value)
    read = flight_from_mapping if "laws" in document else from_mapping
    with pytest.raises(ScenarioError) as caught:
        read(document, origin=f"{name}.toml")
    error = caught.value
    each = error.errors if isinstance(error, ScenarioErrors) else (error,)
    return {str(one) for one in each}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_together_are_those_of_each(name: str) -> None:
    alone = {key: messages(name, {key: value}) for key, value in FAULTS[name].items()}
    assert all(alone.values())
    assert messages(name, FAULTS[name]) == set().union(*alone.values())
    assert len(set().union(*alone.values())) >= 5
    some = random.Random(name).sample(sorted(alone), 2)
    together = messages(name, {key: FAULTS[name][key] for key in some})
    assert together == set().union(*(alone[key] for key in some))


WITHOUT_JAX = """
import json, sys
from pathlib import Path
sys.modules["jax"] = None  # importing it raises
from jaxatt.problems.reading.documents import read_file
from jaxatt.studies.file_kinds import faults_of, kind_of_document
found = {}
for path in map(Path, sys.argv[1:]):
    document = read_file(path)
    faults = faults_of(document, path.name, kind_of_document(document), path.parent)
    found[path.stem] = [str(fault) for fault in faults]
print(json.dumps(found))
"""


def test_most_faults_are_told_without_jax(tmp_path: Path) -> None:
    """Four or more of each file, in the words of the loader; none of files without a fault."""
    files = []
    for name, changes in FAULTS.items():
        document = tomllib.loads(scenarios.text(name))
        for key, value in changes.items():
            assign(document, key, value)
        files.append(tmp_path / f"{name}.toml")
        files[-1].write_text(toml(document), encoding="utf-8")
    good = tmp_path / "good.toml"
    good.write_text(scenarios.text("hypso2-orbit"), encoding="utf-8")
    command = [sys.executable, "-c", WITHOUT_JAX, *map(str, files), str(good)]
    told = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert told.pop("good") == []
    for name, faults in told.items():
        assert len(faults) >= 4, name
        assert set(faults) <= messages(name, FAULTS[name])


def toml(table: dict) -> str:
    """A document as TOML, its tables inline."""
    return "\n".join(f"{key} = {inline(value)}" for key, value in table.items())


def inline(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def test_a_fault_of_a_vehicles_file_is_told_once(tmp_path: Path) -> None:
    """Its keys and its numbers are looked at by two readers."""
    file = tmp_path / "mine.toml"
    file.write_text(
        "inertia_kgm2 = [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]\n"
        "[wheels]\naxes = [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]\n"
        "inertia_kgm2 = 1e-3\ntorque_limit_Nm = -1.0\n",
        encoding="utf-8",
    )
    document = tomllib.loads(file.read_text(encoding="utf-8"))
    (fault,) = faults_of(document, str(file), "vehicle", tmp_path)
    assert "[wheels] torque_limit_Nm = -1.0" in located(fault)
    assert located(fault).startswith(f"{file}:5: ")


def test_figures_of_laws_that_cannot_be_read_are_no_fault() -> None:
    (fault,) = messages("hypso1-pointing-unloading", {"laws": {}})
    assert "holds no law" in fault
