"""Design by descent: against bisection and a grid, and bad studies are refused."""

import json

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import jaxatt
from jaxatt.cli import app
from jaxatt.studies.design.study import read_design
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer

STUDY = """
name = "least-force"
title = "Least force with which the effort is at most 1.95"
scenario = "double-integrator"
minimise = "numbers"
at_most = 1.95

[fixed]
"horizon.intervals" = 20
"solver.starts" = 4

[[vary]]
field = "control.limit"
from = 0.7
to = 1.3
"""


def test_the_least_force_is_that_of_bisection(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    run = CliRunner().invoke(app, ["design", str(study), "--out", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output
    written = json.loads((tmp_path / "out" / "design.json").read_text())
    assert written["settled"] and written["reached"]
    assert (tmp_path / "out" / "design.png").stat().st_size > 0
    scenario = jaxatt.scenarios.replace(
        jaxatt.scenarios.load("double-integrator"),
        {"horizon.intervals": 20, "solver.starts": 4},
    )

    def excess(limit):
        changed = jaxatt.scenarios.replace(scenario, {"control.limit": limit})
        return sensitive_answer(changed).optimum.answer.objective - 1.95

    want = brentq(excess, 0.7, 1.3, xtol=1e-5)
    np.testing.assert_allclose(written["best"], [want], rtol=1e-3)


GOOD = {
    "name": "a",
    "scenario": "double-integrator",
    "minimise": "mean",
    "vary": [{"field": "control.limit", "from": 0.7, "to": 1.3}],
}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"minimise": "least"}, "minimise"),
        ({"minimise": "numbers"}, "at_most"),
        ({"vary": []}, "vary"),
        ({"vary": [{"field": "control.limt", "from": 0.7, "to": 1.3}]}, "control.limit"),
        ({"vary": [{"field": "control.limit", "from": 1.3, "to": 0.7}]}, "not above"),
        ({"vary": GOOD["vary"] * 2}, "twice"),
        ({"vary": [{"field": "control.limit", "from": -1.0, "to": 0.7}]}, "limit"),
        ({"cases": [3]}, "cases"),
        ({"nothing": 1}, "nothing"),
    ],
)
def test_bad_studies_are_refused(change, said):
    with pytest.raises(jaxatt.ScenarioError, match=said):
        read_design({**GOOD, **change})
