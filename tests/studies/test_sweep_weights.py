"""Weights of effort in one chunk: one batch from neighbours' answers, as `sweep_effort` has it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jaxatt
from jaxatt.problems.registry import family_of
from jaxatt.scenarios import load, replace

FEW = {"solver.starts": 4, "horizon.intervals": 12}


@pytest.fixture(scope="module")
def weights() -> np.ndarray:
    return np.exp(np.random.default_rng(1129).uniform(np.log(1e-3), np.log(1.0), 3))


@pytest.mark.slow
def test_a_chunk_of_weights_is_the_sweep_of_effort(tmp_path: Path, weights) -> None:
    study = {
        "scenario": "mrp-k3-rk4",
        "outputs": ["final_time_s", "control_effort", "cost"],
        "chunk": 3,
        "fixed": FEW,
        "vary": [{"field": "objective.effort_weight", "values": weights.tolist()}],
    }
    found = jaxatt.sweep(study, tmp_path / "a.zarr").dataset
    np.testing.assert_array_equal(found.effort_weight, weights)
    path = jaxatt.sweep_effort(replace(load("mrp-k3-rk4"), FEW), weights).curves[0].path
    order = np.argsort(weights)
    for name, values in (
        ("final_time_s", path.final_time),
        ("control_effort", path.quadratic_effort),
        ("cost", path.cost),
    ):
        np.testing.assert_allclose(found[name].values[order], values, rtol=1e-9)
    np.testing.assert_allclose(
        found.cost, found.final_time_s + weights * found.control_effort, rtol=1e-6
    )
    assert (np.diff(found.control_effort.values[order]) < 1e-6).all()


def test_only_samples_that_differ_in_the_weight_go_together(weights) -> None:
    case = replace(load("mrp-k3-rk4"), FEW)
    family = family_of(case)
    heavier = replace(case, {"objective.effort_weight": 2.0 * case.objective.effort_weight})
    assert family.search_many([case, case]) is None
    assert family.search_many([case, replace(heavier, {"solver.seed": 1})]) is None
    assert family.search_many([case, replace(heavier, {"objective.kind": "minimum-time"})]) is None
