"""Kepler's equation from many starts, on however many devices and processes; a script of its own.

    python shared_starts.py STARTS [HOST:PORT PROCESSES PROCESS [WHAT]]

Process 0 prints one JSON document.  WHAT : "killed" ends the last process while the others wait for
its share; "slow" keeps all of them at work until they are ended; "other" gives the last process
starts of its own.
"""

import json
import os
import re
import signal
import sys
import time
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import jaxatt
from jaxatt.multistart import driver
from jaxatt.multistart.driver import Plain, run_starts
from jaxatt.multistart.sharding import ROWS as ROWS_FIRST
from jaxatt.multistart.sharding import placed
from jaxatt.optimize.solver import Solver
from jaxatt.runtime.chunks import in_chunks
from jaxatt.runtime.joining import JoinError, Joining, LostProcessError, leave, writes

COLLECTIVE = re.compile(r"all-reduce|all-gather|all-to-all|collective-permute|reduce-scatter")

ROWS = 8


class Anomaly(NamedTuple):
    eccentric: jax.Array
    mean: jax.Array
    passes: jax.Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Kepler(Solver):
    """Newton's steps for the eccentric anomaly; a start is a mean anomaly, args an eccentricity."""

    tolerance: float = 1e-14

    name = "Newton"
    supports = frozenset({"an orbit"})
    passes = 2

    def init(self, program, start, args):
        return Anomaly(start + args, start, jnp.asarray(0))

    def step(self, program, state, args):
        x = state.eccentric
        x = x - (x - args * jnp.sin(x) - state.mean) / (1.0 - args * jnp.cos(x))
        moved = jnp.abs(x - state.eccentric) > self.tolerance
        return Anomaly(x, state.mean, jnp.where(moved, state.passes + 1, -state.passes - 1))

    def done(self, state):
        return (state.passes < 0) | (state.passes > 60)

    def result(self, program, state, args):
        return {"x": state.eccentric, "passes": jnp.abs(state.passes), "none": jnp.zeros((0, 2))}


@dataclass(frozen=True)
class Orbit:
    """A programme of no solver but this one."""

    features = frozenset({"an orbit"})


PROBLEM, SOLVER, ECCENTRICITY = Plain(Orbit()), Kepler(), np.array(0.9)


def exchanged(lowered):
    """What devices exchange in a program."""
    return COLLECTIVE.findall(lowered.compile().as_text())


def collectives(starts):
    """What they exchange inside the compiled passes, and in a sum over all rows."""
    job = driver._job(SOLVER, PROBLEM)
    rows = ROWS * job.devices
    empty = driver._empty(SOLVER, driver._state(SOLVER, PROBLEM, starts, ECCENTRICITY), rows, job)
    some, fresh = np.resize(starts, rows), np.ones(rows, bool)
    passes = driver.some_passes._jitted.lower(job, some, empty, fresh, ECCENTRICITY, SOLVER)
    parts = placed(job.mesh, np.ones(rows), ROWS_FIRST)
    return exchanged(passes), exchanged(jax.jit(jnp.sum).lower(parts))


def main(count, coordinator=None, processes="1", process="0", what=""):
    last = int(process) == int(processes) - 1
    jaxatt.configure()
    if coordinator is not None:
        Joining(coordinator, int(processes), int(process), 60.0).join()
    rng = np.random.default_rng(8 if what == "other" and last else 7)
    starts = rng.uniform(0.0, 2.0 * np.pi, int(count))
    starts[5] = np.nan
    told = []
    found = run_starts(SOLVER, PROBLEM, starts, ECCENTRICITY, rows=ROWS, progress=told.append)
    sines = in_chunks(jax.jit(jnp.sin), found["x"], 4)
    if what == "killed":
        if last:
            os.kill(os.getpid(), signal.SIGKILL)
        run_starts(SOLVER, PROBLEM, starts, ECCENTRICITY, rows=ROWS)
    if what == "slow":
        print("at work", flush=True)
        time.sleep(600.0)
    if writes():
        document = {
            "devices": jax.local_device_count(),
            "processes": jax.process_count(),
            "starts": starts.tolist(),
            "x": found["x"].tolist(),
            "passes": found["passes"].tolist(),
            "sines": sines.tolist(),
            "none": found["none"].shape,
            "told": told,
        }
        document["collectives"], document["sum"] = collectives(starts)
        print(json.dumps(document))


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except (JoinError, LostProcessError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        leave(4)
