"""The study of net power still says what it should."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from notebook_runs import complaints, outputs, printed, run_notebook

pytestmark = [pytest.mark.slow, pytest.mark.optimised]

PROBE = """
import json
print(json.dumps({
    "turn": turn.to_dict()["rows"],
    "early": [early, float(gained[-1])],
    "orbit": {
        **{name: orbit.to_dict()[name] for name in ("rows", "totals", "findings")},
        "reached": orbit.reached,
        "dark": [float(spent.mean()), float(spent.max())],
        "added": [before["net"], before["PD law"]],
    },
    "weights": [
        {name: value for name, value in row.items() if name != "dipole_Am2"}
        for row in weighed.to_dict()["rows"]
    ],
    "findings": weighed.findings,
    "light": slow.series["light"].tolist(),
}))
"""

COSTS = {1e-8: -15.505, 1e-4: -15.227, 1e-3: -12.809, 1e-2: -7.68, 1e-1: 8.89, 1.0: 120.3}
"""By weight of time, what the best manoeuvre costs at most."""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run_notebook("net_power", tmp_path_factory.mktemp("notebook"), PROBE)


@pytest.fixture(scope="module")
def numbers(notebook: Any) -> Any:
    return printed(notebook)


def test_the_study_of_net_power_shows_the_figures_of_three_chapters(notebook: Any) -> None:
    assert len(outputs(notebook, "image/png")) >= 13
    assert len(outputs(notebook, "text/html")) >= 3
    assert not complaints(notebook)


def test_half_a_turn_earns_more_than_printed(numbers: Any) -> None:
    (row,) = numbers["turn"]
    assert row["baseline_J"] == pytest.approx(501.2, abs=0.3)
    assert row["net_J"] >= 573.45
    assert row["attitude_error_deg"] < 0.01 and math.sqrt(row["rate_error"]) < 1e-5
    early, all_of_it = numbers["early"]
    assert all_of_it == pytest.approx(row["gain_J"], abs=1e-6)
    assert 0.0 < early < 0.1 * all_of_it


def test_every_harvest_of_the_orbit_gains_and_ends_where_it_should(numbers: Any) -> None:
    orbit = numbers["orbit"]
    rows = {row["label"]: row for row in orbit["rows"]}
    harvests = [row for row in orbit["rows"] if row["mode"] == "harvest"]
    assert orbit["reached"] and len(rows) == 20 and len(harvests) == 10
    for row in harvests:
        assert row["gain_J"] > 0.0, row["label"]
        assert row["attitude_error_deg"] < 0.1, row["label"]
        assert math.sqrt(row["rate_error"]) < 1e-4, row["label"]
    total = orbit["totals"][0]
    assert orbit["added"] == pytest.approx([total["net_J"], total["baseline_J"]], abs=1e-3)
    # In the umbra there is nothing to gain, and next to nothing is spent.
    assert orbit["dark"][0] < 0.5


def test_magnetorquers_cost_no_more_than_is_known(numbers: Any) -> None:
    rows = {row["time_weight"]: row for row in numbers["weights"]}
    assert len(rows) == 9
    for weight, most in COSTS.items():
        assert rows[weight]["cost"] <= most, weight
    for row in rows.values():
        assert row["claimed_J"] == pytest.approx(row["net_J"], rel=5e-3)
        assert row["cost"] < row["printed"]["cost"]
    for name in ("final_time_s", "net_J"):
        values = [row[name] for row in numbers["weights"]]
        assert all(after <= before for before, after in itertools.pairwise(values)), name


def test_the_printed_front_is_one_of_local_minima(numbers: Any) -> None:
    text = " ".join(numbers["findings"])
    assert "that of 1e-06 beats 1e-08, 1e-07, 1e-05 and 0.0001" in text
    # What waits for the end of the eclipse loses mean power.
    assert min(numbers["light"][:-1]) > 0.5
