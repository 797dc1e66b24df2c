"""What an accelerator does by batch size: roll-outs, the search and the interior point, timed."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from benchmarks.cases import BEST_KNOWN, task_of
from benchmarks.timing import timed
from benchmarks.usefulness import useful
from jaxatt import scenarios
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.polish import Method, decide, reweight
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.random_paths import random_paths
from jaxatt.problems.time_optimal.search import evaluate

SLEW, TURN = "hypso1-90-45-15", "mrp-k4-rk4"

_SAME = 1e-4
"""Relative difference of costs up to which a turn counts as one at the best."""


@dataclass(frozen=True)
class Rate:
    """One measurement.

    batch : starts in one call.  compile_s : [s].  run_s : [s] median of a call.
    useful_share : of the starts; one for roll-outs, which all are.
    """

    what: str
    precision: str
    batch: int
    compile_s: float
    run_s: float
    useful_share: float

    @property
    def useful_per_second(self) -> float:
        """Starts that are useful, a second."""
        return self.useful_share * self.batch / self.run_s


def in_single(of: Any) -> Any:
    """A pytree with single-precision floats, on the host."""

    def single(leaf: Any) -> Any:
        leaf = np.asarray(leaf)
        return leaf.astype(np.float32) if leaf.dtype == np.float64 else leaf

    return jax.tree.map(single, of)


def rollouts(batch: int, repeats: int, single: bool = False) -> Rate:
    """Roll-outs of 50 intervals."""
    task = task_of(SLEW)
    plant = in_single(task.arguments.plant) if single else task.arguments.plant
    drawn = np.random.default_rng(0).normal(size=(task.intervals, task.size, batch))
    u = drawn.astype(np.float32) if single else drawn
    with jax.enable_x64(not single):
        run = jax.jit(jax.vmap(lambda u, plant: task.system.rows(u, plant), (-1, None), -1))
        u, plant = jax.device_put((u, plant))
        time = timed(lambda _: run(u, plant), repeats)
    name = "float32" if single else "float64"
    return Rate("roll-outs", name, batch, time.compile_s, time.run_s, 1.0)


def searches(batch: int, repeats: int, single: bool = False) -> Rate:
    """Random starts to settled controls; in single precision first, and then settled in double."""
    task = task_of(SLEW)
    method = Method("l0", rows=batch)
    rough = _single_task(task) if single else task

    def run(index: int) -> np.ndarray:
        starts = draw(index, batch, task.intervals, task.size, task.long_way_probability())
        if not single:
            u, supports = decide(task, starts, method)
            return task.to_controls(u * supports)
        with jax.enable_x64(False):
            u, supports = decide(rough, in_single(starts), method)
        free = np.broadcast_to(supports, u.shape) * np.asarray(task.arguments.free)
        lanes = broadcast_lanes(u * free, free, task.arguments.row_weight, starts.sign)
        settled = reweight(task, lanes, method, method.settling(task)).u
        return task.to_controls(np.nan_to_num(settled))

    time = timed(run, repeats)
    share = float(useful(task, run(0), BEST_KNOWN[SLEW]).mean())
    name = "float32, then float64" if single else "float64"
    return Rate(f"search, {SLEW}", name, batch, time.compile_s, time.run_s, share)


def _single_task(task: SparseTask) -> SparseTask:
    other = copy.copy(task)
    other.arguments = in_single(task.arguments)
    return other


def turns(batch: int, repeats: int) -> Rate:
    """Turns in the shortest time by the interior point, from random feasible paths."""
    task = build_time_task(scenarios.load(TURN))
    paths = random_paths(task, batch, 0)
    rows = None if jax.default_backend() == "cpu" else batch
    time = timed(lambda _: solve_paths(task, paths, rows=rows), repeats)
    found = evaluate(task, paths, solve_paths(task, paths, rows=rows))
    best = found.cost[found.best]
    share = float((found.reached & (found.cost <= best * (1.0 + _SAME))).mean())
    return Rate(f"interior point, {TURN}", "float64", batch, time.compile_s, time.run_s, share)
