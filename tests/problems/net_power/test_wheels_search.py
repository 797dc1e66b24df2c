"""Search of manoeuvres with wheels: chapter 4, padded lengths, the family from end to end."""

import json

import numpy as np
import pytest

import jaxatt
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import flown_again, phase_manoeuvre
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.runtime.lengths import shared_length


@pytest.fixture(scope="module")
def result():
    return jaxatt.solve("hypso1-netpower", starts=8)


def test_chapter_four_earns_more_than_printed(result):
    found = net_power(result.phases[0])
    assert result.reached
    assert found.energy.net >= 573.45
    assert abs(found.energy.baseline - 501.2) <= 0.3
    assert np.degrees(result.phases[0].errors["attitude"]) < 0.01
    assert result.phases[0].errors["rate"] < 1e-5
    # Nothing is claimed that the flight does not earn, but for energies that depend on the ends.
    assert found.share > 0.0


def test_summary_names_the_energies(result, tmp_path):
    result.save(tmp_path)
    energy = json.loads((tmp_path / "summary.json").read_text())["energy"]
    assert set(energy) >= {
        "net_J",
        "solar_J",
        "actuation_J",
        "loads_J",
        "mean_power_W",
        "baseline_J",
        "gain_percent",
        "final_charge_J",
    }
    assert energy["net_J"] == pytest.approx(
        energy["solar_J"] - energy["actuation_J"] - energy["loads_J"]
    )
    assert energy["mean_power_W"] == pytest.approx(energy["net_J"] / 40.0)
    assert (tmp_path / "overview.png").stat().st_size > 10_000


def test_filled_up_intervals_change_nothing(result):
    manoeuvre = phase_manoeuvre(result.scenario, PhaseStart())
    (solved,) = search_wheels([manoeuvre], 8, 0, shared=True)
    assert solved.torque.shape == (8, 80, 3)
    found = flown_again(manoeuvre, solved)
    assert found.reached.any()
    assert found.flight.energy.net_J[found.best] == pytest.approx(
        net_power(result.phases[0]).energy.net, abs=0.5
    )


def test_shared_lengths_hold_and_are_few():
    lengths = [shared_length(count) for count in range(1, 4000)]
    assert all(length >= count for count, length in enumerate(lengths, start=1))
    assert lengths == sorted(lengths)
    assert len(set(lengths)) < 25
    assert all(a < 2 * k for k, a in enumerate(lengths, start=1) if k > 64)
    assert all(a < 1.13 * k for k, a in enumerate(lengths, start=1) if k > 1024)
