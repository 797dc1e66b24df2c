"""Weights of effort in one chunk: one batch from neighbours' answers, for each scenario."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jaxatt
from jaxatt.problems.registry import family_of
from jaxatt.problems.time_optimal.effort_path import effort_path
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.scenarios import load, replace

FEW = {"solver.starts": 4, "horizon.intervals": 12}


@pytest.fixture(scope="module")
def weights() -> np.ndarray:
    return np.exp(np.random.default_rng(1129).uniform(np.log(1e-3), np.log(1.0), 3))


@pytest.mark.slow
@pytest.mark.optimised
def test_weights_of_two_scenarios(tmp_path: Path, weights) -> None:
    names = ["mrp-k3-rk4", "mrp-k4-rk4"]
    study = {
        "scenario": names,
        "outputs": ["final_time_s", "control_effort", "cost"],
        "against": ["final_time_s"],
        "chunk": 3,
        "fixed": FEW,
        "vary": [{"field": "objective.effort_weight", "values": weights.tolist()}],
    }
    sweep = jaxatt.sweep(study, tmp_path / "a.zarr")
    assert sweep.complete and sweep.reached and sweep.names == ("scenario", "effort_weight")
    sweep.save(tmp_path)
    grid = sweep.grid().sel(effort_weight=np.sort(weights))
    for name in names:
        found, task = grid.sel(scenario=name), build_time_task(replace(load(name), FEW))
        path = effort_path(task, weights, FEW["solver.starts"], 0)
        for column, values in (
            ("final_time_s", path.final_time),
            ("control_effort", path.quadratic_effort),
            ("cost", path.cost),
        ):
            np.testing.assert_allclose(found[column], values, rtol=1e-9)
        np.testing.assert_allclose(
            found.cost, found.final_time_s + found.effort_weight * found.control_effort, rtol=1e-6
        )
        assert (np.diff(found.control_effort) < 1e-6).all()
    three, four = (grid.sel(scenario=name).cost for name in names)
    assert (four.values < three.values).all()


def test_only_samples_that_differ_in_the_weight_go_together(weights) -> None:
    case = replace(load("mrp-k3-rk4"), FEW)
    family = family_of(case)
    heavier = replace(case, {"objective.effort_weight": 2.0 * case.objective.effort_weight})
    assert family.search_many([case, case]) is None
    assert family.search_many([case, replace(heavier, {"solver.seed": 1})]) is None
    assert family.search_many([case, replace(heavier, {"objective.kind": "minimum-time"})]) is None
