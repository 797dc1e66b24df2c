"""All faults of a file at once, with their lines, and nothing loaded that computes."""

import subprocess
import sys

import pytest

from jaxatt import scenarios
from jaxatt.problems import registry
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import ScenarioErrors
from jaxatt.problems.reading.lines import line_of
from jaxatt.scenarios.bundled import KINDS, names
from jaxatt.studies.file_kinds import faults_of, kind_of_document

BUNDLED = [(kind, name) for kind in KINDS if kind != "imaging" for name in names(kind)]
BAD = """name = "bad"
[vehicle]
use = "hypso1"
wheels.torque_limit = 3e-3
[orbit]
semi_major_axis_km = "6852"
eccentricity = 0.0
inclination_deg = 190.0
raan_deg = 280.0
argument_of_periapsis_deg = 0.0
true_anomaly_deg = 0.0
[initial]
attitude_deg = [0.0, 0.0]
[target]
attitude_deg = [90.0, 45.0, 15.0]
axis = [1.0, 0.0, 0.0]
angle_deg = 3.0
rate_tolerance_rad_s = 0.0
[horizon]
horizon_s = 70.0
[[windows]]
first_interval = 1
last_interval = 2
[[windows]]
first_interval = 1.5
last_interval = 2
"""
LINES = [4, 6, 8, 13, 16, 18, 19, 25]


@pytest.mark.parametrize("kind, name", BUNDLED)
def test_bundled_files_have_no_faults_and_tell_their_kind(kind, name):
    document = parse(scenarios.text(name), name)
    assert kind_of_document(document) == kind
    assert not faults_of(document, name, kind)


def test_every_fault_of_a_file_is_told_with_its_line(tmp_path):
    faults = faults_of(parse(BAD, "bad"), "bad", "manoeuvre")
    assert [line_of(BAD, fault.label, fault.key) for fault in faults] == LINES
    with pytest.raises(ScenarioErrors) as caught:
        scenarios.from_mapping(parse(BAD, "bad"))
    assert len(caught.value.errors) == len(LINES)


def test_the_formats_are_those_of_the_families():
    assert len(registry.formats()) >= 4
    for known in registry.formats():
        family = registry.family_named(known.name)
        for name in ("name", "systems", "kinds", "tables"):
            assert getattr(known, name) == getattr(family, name)


@pytest.mark.parametrize("command", [("check",), ("solve", "--starts", "8"), ("plan",)])
@pytest.mark.parametrize(
    "text, line", [(BAD, "bad.toml:6: [orbit]"), ('name = "x\n', "line 1, column 10")]
)
def test_a_bad_file_is_refused_without_jax(command, text, line, tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    code = (
        "import sys\nfrom jaxatt.cli import main\n"
        "try: main()\n"
        "finally: print([name for name in ('jax', 'scipy', 'xarray') if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *command, str(path)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
    assert line in done.stderr
    assert done.stderr.count("Error: ") == done.stderr.count("\n")
