"""Starts of a small programme, solved by however many devices and processes; a script of its own.

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

import jax
import jax.numpy as jnp
import numpy as np

import jaxatt
from jaxatt.multistart import driver
from jaxatt.multistart.driver import Plain, run_starts
from jaxatt.multistart.sharding import ROWS as ROWS_FIRST
from jaxatt.multistart.sharding import placed
from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.program import Program
from jaxatt.runtime.chunks import in_chunks
from jaxatt.runtime.joining import JoinError, Joining, LostProcessError, leave, writes

COLLECTIVE = re.compile(r"all-reduce|all-gather|all-to-all|collective-permute|reduce-scatter")

CIRCLE = Program(
    objective=lambda x, a, s: jnp.sum((x - a[None]) ** 2),
    curvature=lambda x, a, s: 2.0 * jnp.eye(2)[None],
    equality=lambda x, a: (jnp.sum(x**2) - 1.0)[None],
)
SOLVER, TARGET, ROWS = AugmentedLagrangian(Schedule(penalty=10.0)), np.array([2.0, 1.0]), 8


def exchanged(lowered):
    """What devices exchange in a program."""
    return COLLECTIVE.findall(lowered.compile().as_text())


def collectives(starts):
    """What they exchange inside the compiled passes, and in a sum over all rows."""
    problem = Plain(CIRCLE)
    job = driver._job(SOLVER, problem)
    rows = ROWS * job.devices
    empty = driver._empty(SOLVER, driver._state(SOLVER, problem, starts, TARGET), rows, job)
    some, fresh = np.resize(starts, (rows, *starts.shape[1:])), np.ones(rows, bool)
    passes = driver.some_passes._jitted.lower(job, some, empty, fresh, TARGET, SOLVER)
    parts = placed(job.mesh, np.ones(rows), ROWS_FIRST)
    return exchanged(passes), exchanged(jax.jit(jnp.sum).lower(parts))


def main(count, coordinator=None, processes="1", process="0", what=""):
    last = int(process) == int(processes) - 1
    jaxatt.configure()
    if coordinator is not None:
        Joining(coordinator, int(processes), int(process), 60.0).join()
    rng = np.random.default_rng(8 if what == "other" and last else 7)
    starts = rng.normal(size=(int(count), 1, 2))
    starts[5] = np.nan
    told = []
    found = run_starts(SOLVER, Plain(CIRCLE), starts, TARGET, rows=ROWS, progress=told.append)
    lengths = in_chunks(jax.jit(lambda x: {"length": jnp.linalg.norm(x, axis=-1)}), found.x, 4)
    if what == "killed":
        if last:
            os.kill(os.getpid(), signal.SIGKILL)
        run_starts(SOLVER, Plain(CIRCLE), starts, TARGET, rows=ROWS)
    if what == "slow":
        print("at work", flush=True)
        time.sleep(600.0)
    if writes():
        document = {
            "devices": jax.local_device_count(),
            "processes": jax.process_count(),
            "x": found.x.tolist(),
            "status": found.status.tolist(),
            "iterations": found.iterations.tolist(),
            "length": lengths["length"].tolist(),
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
