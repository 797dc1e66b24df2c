"""Slews of several numbers of intervals by one compiled program."""

from __future__ import annotations

import jax
import numpy as np

import jaxatt
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.search import search
from jaxatt.problems.hands_off.search.shared_lengths import lengthened

STARTS = 8


def slew(name, intervals):
    changes = {"horizon.intervals": intervals, "horizon.coast_intervals": 2, "windows": []}
    scenario = jaxatt.scenarios.replace(jaxatt.scenarios.load(name), changes)
    return build_slew(scenario, enforce_speed_limits=False)


def test_the_answer_is_the_same_and_other_lengths_compile_nothing(compilations):
    own = slew("hypso1-90-45-15", 12)
    alone, shared = (search(task, STARTS, 0) for task in (own, own.sharing_programs()))
    scale = np.abs(alone.starts.controls).max()
    assert scale > 0.0 and alone.best.verdict.reached[0]
    np.testing.assert_allclose(
        shared.starts.controls, alone.starts.controls, rtol=0.0, atol=1e-9 * scale
    )
    np.testing.assert_array_equal(shared.best.rank[0, :2], alone.best.rank[0, :2])
    compilations.clear()
    found = search(slew("hypso1-90-45-15", 14).sharing_programs(), STARTS, 0)
    assert found.best.verdict.reached[0] and found.best.controls.shape[1] == 14
    assert compilations == []


def test_intervals_that_fill_up_change_no_row_and_no_derivative():
    task, rng = slew("hypso1-path", 12), np.random.default_rng(3)
    response = jax.jit(task.system.response)
    u = 0.02 * rng.normal(size=(1, 12, task.size))
    lanes = broadcast_lanes(u, 1.0 + 0.0 * u, task.arguments.row_weight, np.ones(1))
    longer, arguments = lengthened(task.system, lanes, task.arguments, 52)
    assert longer.u.shape[1] == 64
    rows, slopes = response(u[0], task.arguments.plant)
    same, filled = response(longer.u[0], arguments.plant)
    np.testing.assert_allclose(same, rows, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(filled[:12], slopes, rtol=1e-10, atol=1e-13)
    assert not np.any(filled[12:])
