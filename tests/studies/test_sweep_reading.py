"""Studies read from their files: names of numbers, samples, and what is refused."""

from __future__ import annotations

import copy
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.reading.documents import parse
from jaxatt.scenarios import ScenarioError
from jaxatt.studies.sweep.numbers import places, whole_document
from jaxatt.studies.sweep.reading import load_study, read_study

SLEW = {
    "scenario": "hypso1-90-45-15",
    "outputs": ["active_intervals"],
    "vary": [{"field": "vehicle.wheels.torque_limit_Nm", "values": [1e-3, 2e-3]}],
}


def study(**changes):
    return read_study({**copy.deepcopy(SLEW), **changes}, "s.toml")


def vary(**entry):
    return study(vary=[entry])


@pytest.mark.parametrize("name", scenarios.names("study"))
def test_bundled_studies_are_read(name: str) -> None:
    found = load_study(name)
    assert found.name == name
    for index in (0, found.samples - 1):
        scenarios.from_mapping(found.sample(index))


def test_the_study_of_the_page_is_read() -> None:
    page = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.S)
    found = read_study(parse(text, "page"))
    assert found.values.shape == (6, 2) and found.name == "study"
    assert [v.name for v in found.varied] == ["torque_factor", "horizon_s"]
    for number, (_, horizon) in enumerate(found.values):
        assert scenarios.from_mapping(found.sample(number)).horizon.duration == horizon


def test_a_scenario_is_no_study(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(scenarios.text("hypso1-90-45-15"))
    for name in ("hypso1-90-45-15", tmp_path / "mine.toml"):
        with pytest.raises(ScenarioError, match="varies nothing; write a study with scenario ="):
            load_study(name)
    with pytest.raises(ScenarioError, match=r"nowhere.toml: cannot be read"):
        load_study("nowhere.toml")


def test_several_scenarios_have_the_same_samples() -> None:
    names = ["mrp-k3", "hypso1-90-45-15", "mrp-k5"]
    field = {"field": "vehicle.inertia_kgm2.*.*", "change": "multiply", "values": [0.5, 1.0, 2.0]}
    found = study(scenario=names, vary=[field], fixed={"solver.starts": 3})
    assert found.samples == 9
    for index in range(9):
        document = found.sample(index)
        base = whole_document(scenarios.load(names[index // 3]))
        factor = field["values"][index % 3]
        np.testing.assert_allclose(
            document["vehicle"]["inertia_kgm2"], factor * np.array(base["vehicle"]["inertia_kgm2"])
        )
        assert document["target"] == base["target"] and document["solver"]["starts"] == 3
    layout = found.layout()
    assert layout.coordinates["scenario"][1].tolist() == np.repeat(names, 3).tolist()
    assert layout.attributes["quantities"].split() == ["scenario", "inertia_kgm2_factor"]
    alone = study(scenario=names[1], vary=[field])
    assert "scenario" not in alone.layout().coordinates


def test_a_number_of_a_bundled_vehicle_is_set_for_all_wheels() -> None:
    found = study()
    limits = [scenarios.from_mapping(found.sample(k)).vehicle.wheels.torque_limit for k in (0, 1)]
    np.testing.assert_array_equal(limits, [[1e-3] * 4, [2e-3] * 4])


def test_every_entry_is_scaled_and_one_is_added_to() -> None:
    rng = np.random.default_rng(1129)
    factor, turn = rng.uniform(0.5, 2.0), rng.uniform(1.0, 30.0)
    found = study(
        vary=[
            {"field": "vehicle.inertia_kgm2.*.*", "change": "multiply", "values": [factor]},
            {"field": "target.attitude_deg.2", "change": "add", "values": [turn]},
        ]
    )
    before, after = found.bases[0].whole, found.sample(0)
    np.testing.assert_allclose(
        after["vehicle"]["inertia_kgm2"], factor * np.array(before["vehicle"]["inertia_kgm2"])
    )
    assert after["target"]["attitude_deg"] == [90.0, 45.0, 15.0 + turn]
    assert [v.name for v in found.varied] == ["inertia_kgm2_factor", "attitude_deg_2_added"]
    assert before["target"]["attitude_deg"] == [90.0, 45.0, 15.0]


def test_whole_numbers_stay_whole_and_keys_left_out_are_set() -> None:
    rng = np.random.default_rng(1129)
    fields = [
        {"field": "horizon.intervals", "from": 40, "to": 60, "whole": True},
        {"field": "disturbances.sinusoidal_torque_Nm", "from": 0.0, "to": 1e-6},
    ]
    sampling = {"method": "random", "samples": 200, "seed": int(rng.integers(1 << 20))}
    found = study(vary=fields, sampling=sampling)
    counts = [found.sample(k)["horizon"]["intervals"] for k in range(200)]
    assert all(type(count) is int for count in counts)
    assert min(counts) >= 40 and max(counts) <= 60 and len(set(counts)) > 15
    torque = found.sample(7)["disturbances"]["sinusoidal_torque_Nm"]
    assert scenarios.from_mapping(found.sample(7)).disturbances.sinusoidal_torque == torque


def test_one_quantity_moves_several_numbers() -> None:
    fields = ["initial.rate_rad_s.0", "target.rate_rad_s.0"]
    found = vary(field=fields, name="rate", values=[0.01])
    sample = found.sample(0)
    assert sample["initial"]["rate_rad_s"][0] == sample["target"]["rate_rad_s"][0] == 0.01


def test_grid_has_all_combinations_and_keeps_its_ends() -> None:
    rng = np.random.default_rng(1129)
    low, high = np.sort(rng.uniform(0.1, 5.0, 2))
    found = study(
        vary=[
            {"field": "horizon.horizon_s", "values": [60.0, 50.0, 70.0]},
            {"field": "vehicle.wheels.torque_limit_Nm", "from": low, "to": high, "count": 4,
             "spacing": "logarithmic"},
        ]
    )  # fmt: skip
    assert found.values.shape == (12, 2)
    assert found.values[::4, 0].tolist() == [60.0, 50.0, 70.0]
    levels = found.values[:4, 1]
    assert levels[0] == low and levels[-1] == high
    np.testing.assert_allclose(np.diff(np.log(levels)), math.log(high / low) / 3.0)


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol"])
def test_scattered_samples_fill_their_ranges(method: str) -> None:
    rng = np.random.default_rng(1129)
    fields = [
        {"field": "horizon.horizon_s", "from": 50.0, "to": 90.0},
        {"field": "vehicle.wheels.torque_limit_Nm", "from": 1e-4, "to": 1e-2,
         "spacing": "logarithmic"},
    ]  # fmt: skip
    seed = int(rng.integers(1 << 30))
    sampling = {"method": method, "samples": 64, "seed": seed}
    one = study(vary=fields, sampling=sampling)
    assert one.values.shape == (64, 2) and not one.notes
    share = np.stack([(one.values[:, 0] - 50.0) / 40.0, np.log(one.values[:, 1] / 1e-4)], axis=1)
    share[:, 1] /= math.log(100.0)
    assert (share >= 0.0).all() and (share <= 1.0).all()
    if method != "random":  # one in each of 64 slices
        assert (np.sort((share * 64).astype(int), axis=0) == np.arange(64)[:, None]).all()
    again = study(vary=fields, sampling=sampling)
    np.testing.assert_array_equal(one.values, again.values)
    other = study(vary=fields, sampling={**sampling, "seed": seed + 1})
    assert not (one.values == other.values).any()
    if method != "latin-hypercube":
        more = study(vary=fields, sampling={**sampling, "samples": 128})
        np.testing.assert_array_equal(one.values, more.values[:64])


def test_sobol_counts_that_are_no_power_of_two_are_noted() -> None:
    entry = {"field": "horizon.horizon_s", "from": 50.0, "to": 90.0}
    found = study(vary=[entry], sampling={"method": "sobol", "samples": 100})
    assert len(found.values) == 100 and "64 or 128" in found.notes[0]


def test_fixed_values_hold_in_every_sample() -> None:
    document = parse("solver.starts = 7\n[objective]\nkind = 'l1'", "x")
    found = study(fixed=document)
    assert found.sample(1)["solver"]["starts"] == 7
    assert scenarios.from_mapping(found.sample(1)).objective.kind == "l1"


def test_the_study_of_a_store_is_known_by_all_that_matters() -> None:
    one = study()
    same = study(outputs=["active_intervals"])
    others = [
        study(fixed={"solver": {"seed": 1}}),
        study(scenario="hypso1-90-0-0"),
        vary(field="vehicle.wheels.torque_limit_Nm", values=[1e-3, 3e-3]),
    ]
    identity = one.layout().identity
    assert same.layout().identity == identity and json.loads(one.document)["scenario"]
    assert all(other.layout().identity["contents"] != identity["contents"] for other in others)


def test_names_stand_for_the_numbers_that_a_scenario_has() -> None:
    case = scenarios.load("hypso1-90-45-15")
    whole = whole_document(case)
    assert places(case, whole, "vehicle.wheels.torque_limit_Nm.*") == (
        ("vehicle", "wheels", "torque_limit_Nm"),
    )
    assert len(places(case, whole, "initial.wheel_speed_rad_s.*")) == 4
    assert places(case, whole, "windows.*.weight") == (("windows", 0, "weight"),)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vary": [{"field": "vehicle.wheels.torque_limit", "values": [1]}]},
         ["[[vary]] no. 1 field", "such number", "did you mean 'vehicle.wheels.torque_limit_Nm'"]),
        ({"vary": [{"field": "wheels.*.torque_limit_Nm", "values": [1]}]}, ["no such number"]),
        ({"vary": [{"field": "torque_limit_Nm", "values": [1]}]},
         ["did you mean 'vehicle.wheels.torque_limit_Nm'"]),
        ({"vary": [{"field": "objective.kind", "values": [1]}]}, ['"l0"', "is no number"]),
        ({"vary": [{"field": "target.attitude_deg", "values": [1]}]}, ["list of 3", ".0"]),
        ({"vary": [{"field": "target.attitude_deg.3", "values": [1]}]}, ["no such number"]),
        ({"vary": [{"field": "horizon", "values": [1]}]}, ["is a table", "horizon.horizon_s"]),
        ({"vary": [{"field": 3, "values": [1]}]}, ["field = 3", "must be a text"]),
        ({"vary": [{"values": [1]}]}, ["field", "missing"]),
        ({"vary": []}, ["vary", "write [[vary]]"]),
        ({"scenario": []}, ["scenario", "no list of names"]),
        ({"scenario": ["mrp-k3", "mrp-k3"]}, ["names mrp-k3 twice"]),
        ({"scenario": ["hypso1-90-45-15", "double-integrator"]},
         ["[[vary]] no. 1 field", "double-integrator has no such number"]),
        ({"scenario": ["hypso1-90-45-15", "mrp-k3"],
          "vary": [{"field": "vehicle.wheels.torque_limit_Nm", "name": "scenario", "values": [1]}]},
         ["tells the scenarios apart"]),
        ({"against": "active_intervals"}, ["against", "must be a list of texts"]),
        ({"against": ["cost"]}, ["against", "cost is no output"]),
        ({"vary": [{"field": "horizon.horizon_s", "values": []}]}, ["no list of numbers"]),
        ({"vary": [{"field": "horizon.horizon_s", "values": ["a"]}]}, ["not a number"]),
        ({"vary": [{"field": "horizon.horizon_s", "values": [1.0, 1.0]}]}, ["twice"]),
        ({"vary": [{"field": "horizon.horizon_s", "from": 2.0, "to": 1.0, "count": 2}]},
         ["to = 1.0", "exchange"]),
        ({"vary": [{"field": "horizon.horizon_s", "from": 1.0, "to": 2.0}]}, ["count", "missing"]),
        ({"vary": [{"field": "horizon.horizon_s", "from": 1.0, "to": 2.0, "count": 1}]},
         ["count = 1", "at least 2"]),
        ({"vary": [{"field": "horizon.horizon_s", "from": 0.0, "to": 2.0, "count": 3,
                    "spacing": "logarithmic"}]}, ["spacing", "linear"]),
        ({"vary": [{"field": "disturbances.sinusoidal_torque_Nm", "change": "multiply",
                    "values": [2]}]}, ["leaves", "set"]),
        ({"vary": [{"field": "horizon.horizon_s", "values": [1]}] * 2}, ["name of its own"]),
        ({"vary": [{"field": "horizon.horizon_s", "values": [1], "name": "a"},
                   {"field": "horizon.horizon_s", "values": [1], "name": "b"}]}, ["set by a"]),
        ({"vary": [{"field": "horizon.horizon_s", "from": 1.0, "to": 2.0, "count": 10**6},
                   {"field": "solver.starts", "from": 1.0, "to": 2.0, "count": 10**6}]},
         ["1000000 x 1000000", "at most"]),
        ({"sampling": {"method": "sobl", "samples": 4}}, ["did you mean 'sobol'"]),
        ({"sampling": {"method": "random"}}, ["samples", "missing"]),
        ({"sampling": {"method": "random", "samples": 0}}, ["samples = 0", "at least 1"]),
        ({"sampling": {"method": "random", "samples": -5}}, ["samples = -5"]),
        ({"sampling": {"method": "random", "samples": 10**12}}, ["samples", "at most"]),
        ({"sampling": {"method": "random", "samples": 1.5}}, ["whole number"]),
        ({"sampling": {"samples": 4}}, ["samples", "a grid has"]),
        ({"outputs": []}, ["outputs", "no list of names"]),
        ({"outputs": ["cost", "cost"]}, ["cost twice"]),
        ({"outputs": ["time_s.solve"]}, ["clock"]),
        ({"scenario": "hypso1-90-45-16"}, ["did you mean 'hypso1-90-45-15'"]),
        ({"fixed": {"solver.starts": -1}}, ["starts"]),
        ({"fixed": 3}, ["[fixed]"]),
        ({"varry": 3}, ["did you mean 'vary'"]),
        ({"name": "../x"}, ["name"]),
        ({"chunk": 0}, ["chunk = 0"]),
    ],
)  # fmt: skip
def test_bad_studies_are_refused_with_a_sentence(changes, words) -> None:
    with pytest.raises(ScenarioError) as caught:
        study(**changes).layout()
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize("name", ["active_intervals", "done", "state", "a b", "", "1"])
def test_names_that_clash_are_refused(name: str) -> None:
    with pytest.raises(ScenarioError, match="name"):
        vary(field="horizon.horizon_s", values=[1.0], name=name).layout()
