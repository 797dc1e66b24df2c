"""Energies beside the PD law and beside printed values."""

import json
import math
from types import SimpleNamespace

import handmade_net_power
import handmade_results
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.attitude import errors
from jaxatt.studies import energy_comparison
from jaxatt.studies.compare import compare
from jaxatt.studies.energy_comparison import compare_energy, quaternion_error


@pytest.fixture
def solved(monkeypatch):
    """Let `solve` return these phases; what it was asked with."""
    asked = []

    def use(*phases):
        def solve(scenario, **options):
            asked.append(options)
            return handmade_results.assemble(scenario, *phases)

        monkeypatch.setattr(energy_comparison, "solve", solve)
        return asked

    return use


def orbit_phases(gains, **changes):
    """The twenty tasks of hypso2-orbit; harvests gain so much over the printed PD law."""
    scenario = scenarios.load("hypso2-orbit")
    printed = {row["label"]: row for row in scenario.printed["rows"]}
    for task in scenario.document["tasks"]:
        name, known = task["name"], printed.get(task["name"])
        base = -500.0 if known is None else known["baseline_J"]
        net = base if known is None else base + gains[name]
        yield handmade_net_power.phase(
            net,
            baseline=base,
            baseline_errors=(1e-3, 1e-2),
            task=name,
            mode=task["mode"],
            **changes.get(name, {}),
        )


def test_the_quaternion_error_is_exact_for_large_and_small_angles():
    random = np.random.default_rng(5)
    axis = random.normal(size=3)
    axis /= np.linalg.norm(axis)
    for angle in (math.pi, *random.uniform(0.0, math.pi, 5)):
        q = np.concatenate([[math.cos(0.5 * angle)], math.sin(0.5 * angle) * axis])
        metric = float(errors.pseudo_metric(np.array([1.0, 0.0, 0.0, 0.0]), q))
        assert quaternion_error(angle) == pytest.approx(metric, abs=1e-14)
    # Where 1 - cos loses all its digits.
    assert quaternion_error(1e-9) == pytest.approx(1.25e-19, rel=1e-9)


def test_a_manoeuvre_beside_table_4_2(solved):
    asked = solved(handmade_net_power.phase(573.5, baseline=501.2, baseline_errors=(6e-3, 7e-3)))
    found = compare("hypso1-netpower", starts=3, seed=9)
    assert asked[0]["starts"] == 3 and asked[0]["seed"] == 9
    (row,) = found.rows
    assert row.gain_J == pytest.approx(72.3) and not found.totals
    assert row.rate_error == pytest.approx(1e-10) and row.baseline_rate_error == pytest.approx(
        4.9e-5
    )
    text = " ".join(str(found).split())
    assert "573.5 566.4 501.2 501.2 +72.3 +65.2 +14.4 +13" in text
    assert "Gain over the PD law: +72.3 J (printed +65.2 J)." in text
    assert "The printed optimum is a local one" in text


def test_a_plan_beside_tables_5_7_and_5_8(solved):
    random = np.random.default_rng(3)
    names = [row["label"] for row in scenarios.load("hypso2-orbit").printed["rows"]]
    gains = dict(zip(names, random.uniform(600.0, 900.0, 10), strict=True))
    gains |= {"harvest 2": 10.0, "harvest 7": -1.0}
    phases = list(orbit_phases(gains, **{"harvest 4": {"errors": (0.5, 1e-5)}}))
    solved(*phases)
    found = compare_energy(scenarios.load("hypso2-orbit"))
    assert len(found.rows) == 20 and not found.reached
    assert [total.label.strip() for total in found.totals][:3] == [
        "all tasks",
        "harvests",
        "loads aside",
    ]
    assert found.totals[0].net_J == pytest.approx(sum(row.net_J for row in found.rows))
    text = " ".join(str(found).split())
    printed = found.printed.values()
    asked = sum(row["net_J"] for row in printed) - sum(row["baseline_J"] for row in printed)
    assert asked == pytest.approx(3229.0, abs=1.0)
    assert f"{sum(gains.values()):+.1f} J in 10 manoeuvres (printed {asked:+.1f} J)" in text
    assert "less than printed in: harvest 2, harvest 7." in text
    assert "The PD law earns as much or more in: harvest 7." in text
    assert "Not flown as asked: harvest 4." in text
    # Printed totals stand beside those of the same tasks.
    assert " 31892.0 " in text and " 41895.0 " in text and " -18.8 " in text
    assert max(len(line) for line in str(found).splitlines()) <= 100
    assert "…" not in str(found)


def test_files_of_a_comparison_of_energies(solved, tmp_path, monkeypatch):
    solved(handmade_net_power.phase(573.5, baseline=501.2))
    # The files of single results have their own tests, and figures take seconds.
    drawn = SimpleNamespace(write_png=lambda path: path.write_bytes(b""))
    monkeypatch.setattr(energy_comparison.plots, "plot", lambda result: drawn)
    monkeypatch.setattr(energy_comparison, "save_result", lambda result, folder: [folder / "files"])
    files = compare_energy(scenarios.load("hypso1-netpower")).save(tmp_path / "out")
    assert {file.name for file in files} == {"comparison.json", "comparison.png", "files"}
    written = json.loads((tmp_path / "out/comparison.json").read_text())
    assert written["rows"][0]["gain_J"] == pytest.approx(72.3)
    assert written["printed"]["rows"][0]["net_J"] == 566.4
