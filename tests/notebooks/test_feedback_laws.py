"""The study of feedback laws still says what it should."""

from __future__ import annotations

from typing import Any

import pytest
from notebook_runs import complaints, outputs, printed, run_notebook

pytestmark = pytest.mark.slow

PROBE = """
import json
print(json.dumps({
    "lines": [
        [c.scenario.name, line.law, line.figure, line.worst]
        for c in (pointing, slewing, table_f2, table_1) for line in c.lines
    ],
    "benchmark": [
        [line.reproduced, float(line.obtained[0])] for line in table_f2.lines
        if (line.law, line.figure) == ("PD benchmark", "settling_worst_s")
    ],
    "tuned": [float(printed.settling[printed.chosen]), tuned.values["settling"]],
    "campaign": campaign.summary()["settled"],
    "gsd": imaging.fitted.altitude_km,
}))
"""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("notebook")
    return run_notebook("feedback_laws", folder, PROBE, optimised=False)


@pytest.fixture(scope="module")
def numbers(notebook: Any) -> Any:
    return printed(notebook)


def test_the_notebook_shows_its_figures(notebook: Any) -> None:
    assert len(outputs(notebook, "image/png")) >= 13
    assert not complaints(notebook)


def test_printed_tables_are_met(numbers: Any) -> None:
    worst = {tuple(line[:3]): line[3] for line in numbers["lines"]}
    for law in ("PD", "GSTA", "SMC"):
        assert worst["hypso1-pointing", law, "settling_s"] < 0.05, law
    for law in ("gain-scheduled min-norm", "Krstic-Tsiotras"):
        assert worst["microsatellite-large-slew", law, "peak_Nm"] < 0.01, law
    rest = "microsatellite-rest-to-rest"
    assert worst[rest, "gain-scheduled min-norm", "settling_worst_s"] < 0.04
    ((reproduced, settling),) = numbers["benchmark"]
    assert not reproduced and settling == pytest.approx(186.9, rel=0.01)


def test_descent_the_campaign_and_the_altitude(numbers: Any) -> None:
    printed_gains, tuned = numbers["tuned"]
    assert tuned < printed_gains - 1.0
    assert numbers["campaign"] >= 195
    assert numbers["gsd"] == pytest.approx(554.0, abs=3.0)
