"""What a certificate says, against supports counted by hand and figures from elsewhere."""

import itertools
import json
import math

import numpy as np
import pytest
import xarray

import jaxatt
from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.enumeration import (
    classes_up_to,
    enumerate_class,
    group_weights,
    masks_of,
    try_supports,
)
from jaxatt.problems.hands_off.search.polish import Method


@pytest.fixture(scope="module")
def certificate():
    return jaxatt.certify("hypso1-90-45-15", starts=8)


@pytest.fixture(scope="module")
def moving():
    return jaxatt.certify("hypso1-90-45-15", starts=16, objective="moving-l0")


def test_two_intervals_are_the_fewest_and_the_pairs_are_those_known(certificate):
    (phase,) = certificate.phases
    assert certificate.minimal and phase.found.active_intervals == 2
    assert [record.kind.number for record in phase.cheaper] == [1, 50]
    (pairs,) = phase.equal
    assert pairs.kind.number == 1225
    # An independent experiment found these 666, all at least 14 intervals apart.
    assert pairs.short.reached.sum() == 666
    apart = np.diff(pairs.short.groups[pairs.short.reached][:, :, 0], axis=1)
    assert apart.min() == 14
    assert 0 < pairs.long.reached.sum() < 666


def test_the_best_pair_is_the_one_of_least_effort_and_the_answer_has_it(certificate):
    (phase,) = certificate.phases
    np.testing.assert_array_equal(phase.best[:, 0], [0, 49])
    np.testing.assert_allclose(phase.best_effort, phase.found.l1_effort, rtol=1e-5)
    assert "intervals 0, 49" in " ".join(certificate.sentences())


def test_pairs_said_to_reach_do_so_in_flight_and_others_do_not(certificate):
    (phase,) = certificate.phases
    pairs = phase.equal[0].short
    task = build_slew(certificate.result.scenario)
    rng = np.random.default_rng(0)
    for reached in (True, False):
        rows = rng.permutation(np.flatnonzero(pairs.reached == reached))[:16]
        u, _, _ = try_supports(task, pairs.groups[rows], 1.0, Method("l0"))
        verdict, _ = task.verify(task.to_controls(np.nan_to_num(u)))
        assert (verdict.reached == reached).all()


def test_files_can_be_read_again(certificate, tmp_path):
    files = certificate.save(tmp_path / "out")
    assert {file.name for file in files} == {
        "certificate.json",
        "certificate.nc",
        "certificate.png",
    }
    numbers = json.loads((tmp_path / "out" / "certificate.json").read_text())
    assert numbers["minimal"] is True
    (phase,) = numbers["legs"]
    assert phase["best_support"] == [0, 49]
    assert [c["reach_short_way"] for c in phase["classes"]] == [0, 0, 666]
    stored = xarray.load_dataset(tmp_path / "out" / "certificate.nc", engine="h5netcdf")
    pairs = (stored.way_round == 1) & (stored.weighted_cost == 2)
    short = stored.isel(support=np.flatnonzero(pairs))
    assert int(short.reached.sum()) == 666
    best = short.isel(support=int(np.nanargmin(short.l1_effort.values)))
    assert best.interval.values.tolist() == [0, 49]


@pytest.mark.slow
def test_moving_hands_off_is_measured_by_weight(moving):
    (phase,) = moving.phases
    assert moving.minimal
    np.testing.assert_allclose(phase.found_cost, 0.004)
    # Eleven cheap intervals: none, one, two or three of them cost less than four.
    assert [record.kind.number for record in phase.cheaper] == [1, 11, 55, 165]
    assert [record.kind.number for record in phase.equal] == [330]
    assert phase.equal[0].reached.any()


def test_what_is_out_of_reach_is_said_with_its_cost():
    few = jaxatt.certify("hypso1-90-45-15", starts=8, most=60)
    (phase,) = few.phases
    assert few.minimal  # 51 cheaper supports are within the limit
    assert not phase.equal[0].tried and phase.best is None
    assert "Not tried: the 1225 supports of 2" in " ".join(few.sentences())
    fewer = jaxatt.certify("hypso1-90-45-15", starts=8, most=10)
    assert not fewer.minimal
    assert "Out of reach: 50 cheaper supports" in " ".join(fewer.sentences())


def test_a_limit_too_small_leaves_nothing_to_certify():
    scenario = scenarios.replace(
        scenarios.load("hypso1-90-45-15"), {"vehicle.wheels.torque_limit_Nm": 1e-5}
    )
    certificate = jaxatt.certify(scenario, starts=8)
    assert not certificate.minimal
    assert certificate.sentences() == [
        "No answer reaches the target, so there is nothing to certify."
    ]
    assert certificate.plot() is not None


@pytest.mark.parametrize(
    ("name", "objective", "words"),
    [
        ("hypso1-90-45-15", "l1", "l1"),
        ("mrp-k4", None, "time-effort.*not a matter of supports"),
        ("van-der-pol", None, "limits along the way"),
    ],
)
def test_where_enumeration_means_nothing_it_says_so(name, objective, words):
    with pytest.raises(jaxatt.ScenarioError, match=words):
        jaxatt.certify(name, objective=objective, starts=8)


def test_wheel_speed_limits_are_path_constraints():
    limited = {"vehicle.wheels.speed_limit_rad_s": 5.2}
    scenario = scenarios.replace(scenarios.load("hypso1-90-45-15"), limited)
    with pytest.raises(jaxatt.ScenarioError, match="speed_limit_rad_s"):
        jaxatt.certify(scenario, starts=8)


def test_classes_hold_every_support_once():
    scenario = scenarios.replace(
        scenarios.load("hypso1-90-45-15"),
        {"objective.kind": "moving-l0", "objective.design": 2},
    )
    task = build_slew(scenario)
    weight = group_weights(task)
    assert weight.shape == (50, 3)
    classes = classes_up_to(task, 2.0)
    assert classes[0].size == 0
    assert all(a.cost <= b.cost for a, b in itertools.pairwise(classes))
    inside, outside = 33, 117
    numbers = {kind.counts: kind.number for kind in classes}
    assert numbers[(2, 1)] == math.comb(inside, 2) * outside
    kind = next(kind for kind in classes if kind.counts == (2, 0))
    found = enumerate_class(task, kind, 1.0, Method("l0"))
    masks = masks_of(task, found.groups)
    assert len({mask.tobytes() for mask in masks}) == kind.number == math.comb(inside, 2)
    assert (masks.sum(axis=(1, 2)) == 2).all()
    assert not masks[:, :20].any() and not masks[:, 31:].any()
