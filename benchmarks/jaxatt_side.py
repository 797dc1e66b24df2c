"""The package's own side: roll-outs, derivatives, searches and certificates, timed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases import BEST_KNOWN, task_of
from benchmarks.peak import fused_peak, operations
from benchmarks.timing import timed
from benchmarks.usefulness import reaching, useful
from jaxatt.problems.hands_off.search.enumeration import classes_up_to, enumerate_class
from jaxatt.problems.hands_off.search.polish import Method, decide
from jaxatt.problems.hands_off.search.search import look
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.chunks import chunk_for, cores, in_chunks


@dataclass(frozen=True)
class Throughput:
    """One measurement.

    batch : starts in one call.  compile_s : [s].  run_s : [s] median of a call.
    per_second : starts a second.  useful_share : of the starts; None where it means nothing.
    peak_share : of the machine's fused peak; None where operations were not counted.
    """

    what: str
    batch: int
    compile_s: float
    run_s: float
    per_second: float
    useful_share: float | None = None
    peak_share: float | None = None


_ROWS = 128
"""Roll-outs in one chunk at most, where a core is fastest."""


def rollouts(batch: int, repeats: int) -> list[Throughput]:
    """Roll-outs of 50 intervals, and the terminal rows' exact Jacobian, on all cores.

    The fused peak is measured again beside every batch, in the same minute of the machine.
    """
    task = task_of("hypso1-90-45-15")
    plant, rows = task.arguments.plant, max(chunk_for(batch), min(_ROWS, batch // cores()))

    def one(u: jax.Array) -> jax.Array:
        return task.system.rows(u, plant)

    def slopes(u: jax.Array) -> jax.Array:
        assert task.system.response is not None
        return task.system.response(u, plant)[1]

    # Starts last, as the searches have them; leading axis the chunks.
    forward = jax.jit(lambda u: jax.vmap(one, in_axes=-1, out_axes=-1)(u[0])[None])
    gradient = jax.jit(lambda u: jax.vmap(slopes, in_axes=-1, out_axes=0)(u[0])[None])
    count = operations(one, jnp.zeros((task.intervals, task.size)))
    rng = np.random.default_rng(0)
    u = 0.01 * rng.normal(size=(batch // rows, task.intervals, task.size, rows))
    found = []
    for what, run, work in (("roll-outs", forward, count), ("Jacobians", gradient, None)):
        before = fused_peak()
        time = timed(lambda _, run=run, what=what: in_chunks(run, u, 1, key=what), repeats)
        rate = batch / time.run_s
        share = None if work is None else rate * work / (0.5 * (before + fused_peak()))
        found.append(Throughput(what, batch, time.compile_s, time.run_s, rate, peak_share=share))
    return found


def searches(
    case: str, batch: int, repeats: int, inner: str = "auto", polished: bool = False
) -> Throughput:
    """Random starts to settled controls: supports decided, frozen and settled.

    Every repetition has starts of its own, and their drawing counts.
    polished : whether the starts are ended as `jaxatt solve` ends them: the least effort on the
        supports, fewer intervals where there is one control, and the answers flown.
    """
    task, decided = task_of(case), deciding(case, batch, inner)

    def run(index: int) -> np.ndarray:
        return look(task, batch, index).controls if polished else decided(index)

    time = timed(run, repeats)
    share = float(np.mean([_useful(task, run(index), case) for index in range(3)]))
    name = "search and polish" if polished else "search"
    name = name if inner == "auto" else f"{name}, {inner}"
    return Throughput(
        f"{name}, {case}", batch, time.compile_s, time.run_s, batch / time.run_s, share
    )


def deciding(case: str, batch: int, inner: str = "auto") -> Callable[[int], np.ndarray]:
    """Function from a seed to the controls (S, N, b) of that many random starts, settled."""
    task, rows = task_of(case), chunk_for(batch)
    method = Method("l0", "riccati" if inner == "riccati" else "gauss-newton", True, rows)
    long_way = task.long_way_probability()

    def run(seed: int) -> np.ndarray:
        starts = draw(seed, batch, task.intervals, task.size, long_way)
        u, supports = decide(task, starts, method)
        return task.to_controls(u * supports)

    return run


def _useful(task: SparseTask, controls: np.ndarray, case: str) -> float:
    return float(useful(task, controls, BEST_KNOWN[case]).mean())


def reach_share(case: str, batch: int) -> float:
    """Share of starts that reach, with however many intervals."""
    task = task_of(case)
    starts = draw(0, batch, task.intervals, task.size, task.long_way_probability())
    u, supports = decide(task, starts, Method("l0", rows=chunk_for(batch)))
    return float(reaching(task, task.to_controls(u * supports)).mean())


def certificates(case: str, repeats: int) -> dict[str, float]:
    """Seconds for all pairs of intervals, each way round, and how many of them reach."""
    task = task_of(case)
    pairs = next(kind for kind in classes_up_to(task, 2.0) if kind.size == 2)
    found: dict[str, float] = {"pairs": pairs.number}
    for name, sign in (("short", 1.0), ("long", -1.0)):
        time = timed(lambda _, sign=sign: enumerate_class(task, pairs, sign, Method("l0")), repeats)
        reached = enumerate_class(task, pairs, sign, Method("l0")).reached
        found |= {f"{name}_s": time.run_s, f"{name}_reach": int(reached.sum())}
    return found
