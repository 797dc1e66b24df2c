"""Manoeuvres in free time for many weights of time beside printed ones."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import handmade_net_power
import numpy as np
import pytest

from jaxatt import ScenarioError, scenarios
from jaxatt.studies import weight_comparison
from jaxatt.studies.compare import compare
from jaxatt.studies.weight_comparison import STARTS, WeightRow, compare_weights
from jaxatt.studies.weight_findings import better_rows, weight_findings

NAME = "mtq-free-time"
TIMES = [2793.5, 2793.4, 2793.0, 2750.0, 2534.7, 1645.9, 456.7, 145.4, 108.9]
POWERS = [15.45, 15.45, 15.45, 15.45, 15.444, 14.909, 12.293, 6.15, 6.033]


@pytest.fixture
def asked(monkeypatch):
    """Fronts made by hand in the place of searches; the scenarios and requests."""
    seen = []

    def front(scenario, request, report):
        seen.append((scenario, request))
        phases = [
            handmade_net_power.phase(
                power * time,
                seconds=time,
                errors=(1e-7 if time > 200.0 else 0.1, 1e-4),
                claimed=power * time * 1.0002,
                dipole=True,
            )
            for time, power in zip(TIMES, POWERS, strict=True)
        ]
        return SimpleNamespace(phases=tuple(phases))

    family = SimpleNamespace(front=front)
    monkeypatch.setattr(weight_comparison, "family_of", lambda scenario: family)
    return seen


def rows_of(weights, times, energies, losses):
    return [
        WeightRow(k, e, t, 0.0, 0.0, k * t - e / t + loss)
        for k, t, e, loss in zip(weights, times, energies, losses, strict=True)
    ]


def test_all_weights_of_table_6_4_are_one_front(asked):
    found = compare(NAME)
    ((scenario, request),) = asked
    assert scenario.solver.starts == STARTS and request.over == "time"
    assert request.values.tolist() == [10.0**k for k in range(-8, 1)]
    assert [row.final_time_s for row in found.rows] == pytest.approx(TIMES)
    # (6.2a) of the printed values: k1 and k2 of table 6.2.
    first = found.printed[0]
    cost = 2e3 * 4.1068e-5 + 2e5 * 1.7212e-7 + 1e-8 * 5086.0 - 40068.0 / 5086.0
    assert first.cost == pytest.approx(cost, rel=1e-12)
    mine = 2e3 * 2.0 * math.sin(0.25 * 1e-7) ** 2 + 2e5 * 1e-8 + 1e-8 * 2793.5 - 15.45
    assert found.rows[0].cost == pytest.approx(mine, rel=1e-9)


def test_what_the_table_says_of_the_printed_rows(asked):
    found = compare(NAME, starts=2)
    assert asked[0][0].solver.starts == 2 and found.reached
    text = " ".join(str(found).split())
    assert "of k3, that of 1e-06 beats 1e-08, 1e-07, 1e-05 and 0.0001." in text
    assert "up to 51 s long" in text
    assert "differ by 0.02 % at most" in text
    assert "k3 = 0.1 (5.7 deg off), 1 (5.7 deg off)." in text
    assert "43159.6 (40068) 2793.5 (5086) 15.450 (7.878)" in text
    assert max(len(line) for line in str(found).splitlines()) <= 100
    assert "…" not in str(found) and "mean power" in found._repr_html_()


def test_where_the_end_is_a_constraint_a_miss_is_one(asked):
    scenario = scenarios.load(NAME)
    reach = replace(scenario, objective=replace(scenario.objective, terminal="reach"))
    assert not compare_weights(reach).reached


def test_files_of_a_comparison_of_weights(asked, tmp_path):
    files = compare_weights(scenarios.load(NAME)).save(tmp_path / "out")
    assert {file.name for file in files} == {"comparison.json", "comparison.png"}
    written = json.loads((tmp_path / "out/comparison.json").read_text())
    assert [row["time_weight"] for row in written["rows"]] == [10.0**k for k in range(-8, 1)]
    assert written["rows"][5]["printed"]["net_J"] == 21509.0
    assert np.shape(written["rows"][0]["dipole_Am2"]) == (4, 3)


@pytest.mark.parametrize(
    "change",
    [
        {"printed.net_J": [1.0, 2.0]},
        {"printed.time_weight_W_s": [10.0**-k for k in range(9)]},
        {"printed.final_time_s": ["long"] * 9},
        {"printed.time_weight_W_s": [0.0, *(10.0**k for k in range(-7, 1))]},
    ],
)
def test_printed_lists_that_do_not_fit_are_refused(asked, change):
    with pytest.raises(ScenarioError, match=r"\[printed\] time_weight_W_s, net_J.*rising"):
        compare(scenarios.replace(scenarios.load(NAME), change))
    assert not asked


def test_rows_that_another_one_beats_are_found_as_by_trying_all():
    random = np.random.default_rng(8)
    for _ in range(20):
        count = int(random.integers(2, 7))
        weights = np.sort(10.0 ** random.uniform(-8.0, 0.0, count))
        times, energies = random.uniform(100.0, 5000.0, (2, count))
        losses = random.uniform(0.0, 5.0, count)
        rows = rows_of(weights, times, energies, losses)
        for k, best in enumerate(better_rows(rows)):
            tried = [
                weights[k] * t - e / t + loss
                for t, e, loss in zip(times, energies, losses, strict=True)
            ]
            assert tried[best] == pytest.approx(min(tried))


def test_findings_name_what_does_not_fall_and_what_is_worse():
    good = rows_of([0.1, 1.0], [300.0, 200.0], [10000.0, 1500.0], [0.0, 0.0])
    bad = rows_of([0.1, 1.0], [200.0, 300.0], [1500.0, 1000.0], [0.0, 0.0])
    text = " ".join(weight_findings(good, bad, [10000.0, 1500.0], 10))
    assert "for 2 of 2 weights" in text and "fall with k3 throughout" in text
    text = " ".join(weight_findings(bad, good, [1500.0, 1100.0], 10))
    assert "Not falling with k3 throughout: time." in text
    assert "not for k3 = 0.1 and 1" in text and "differ by 10 % at most" in text
    assert "Of those found not all are best: of k3, that of 0.1 beats 1." in text
